//! Standard scaling: zero mean and unit deviation on the rows that learn.

use values::Residual;

/// Below this deviation a column is constant, and is only shifted: its last digits are no information.
const CONSTANT: f64 = 1e-9;

/// Mean and standard deviation of each column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaling<const N: usize> {
    pub(crate) mean: [f64; N],
    pub(crate) deviation: [f64; N],
}

impl<const N: usize> Scaling<N> {
    pub(crate) fn fit(rows: &[[f64; N]]) -> Self {
        let count = rows.len() as f64;
        let mean = std::array::from_fn(|i| rows.iter().map(|row| row[i]).sum::<f64>() / count);
        let deviation = std::array::from_fn(|i| {
            let variance = rows
                .iter()
                .map(|row| (row[i] - mean[i]).powi(2))
                .sum::<f64>()
                / count;
            if variance.sqrt() > CONSTANT {
                variance.sqrt()
            } else {
                1.0
            }
        });
        Self { mean, deviation }
    }

    pub(crate) fn scale(&self, row: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| (row[i] - self.mean[i]) / self.deviation[i])
    }
}

/// What the network sees of a row, in SI units.
pub(crate) fn inputs(row: &Residual) -> [f64; 4] {
    [row.path.x, row.path.y, row.speed_sim, row.angle_sim]
}

/// What it must answer, in SI units.
pub(crate) fn targets(row: &Residual) -> [f64; 2] {
    [row.d_speed, row.d_angle]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_columns_have_zero_mean_and_unit_deviation() {
        let rows = [[1.0, 5.0], [2.0, 5.0], [6.0, 5.0]];
        let scaling = Scaling::fit(&rows);
        let scaled: Vec<_> = rows.iter().map(|row| scaling.scale(row)).collect();
        let sum: f64 = scaled.iter().map(|row| row[0]).sum();
        let squares: f64 = scaled.iter().map(|row| row[0] * row[0]).sum();
        assert!(sum.abs() < 1e-12 && (squares / 3.0 - 1.0).abs() < 1e-12);
        assert!(
            scaled.iter().all(|row| row[1] == 0.0),
            "a constant column is only shifted"
        );
    }
}
