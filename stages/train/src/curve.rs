//! How the error falls with the number of strikes.

/// Strikes at which a curve is drawn.
const SIZES: [usize; 7] = [10, 20, 35, 50, 100, 200, 500];
/// Numbers of the earliest strikes to learn from for a curve: 10 to 500, those that exceed `count` cut to it, once.
pub fn curve_sizes(count: usize) -> Vec<usize> {
    let mut sizes = SIZES.map(|size| size.min(count)).to_vec();
    sizes.dedup();
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_ends_at_all_rows() {
        assert_eq!(curve_sizes(900), [10, 20, 35, 50, 100, 200, 500]);
        assert_eq!(curve_sizes(120), [10, 20, 35, 50, 100, 120]);
        assert_eq!(curve_sizes(8), [8]);
    }
}
