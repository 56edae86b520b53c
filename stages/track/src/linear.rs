//! Small systems of linear equations.

/// Solves N equations, each row with its right side last (Gauss, with pivots); none where they are singular.
pub(crate) fn solve<const N: usize, const M: usize>(mut rows: [[f64; M]; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let pivot =
            (column..N).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))?;
        rows.swap(column, pivot);
        let head = rows[column][column];
        if head.is_nan() || head.abs() < 1e-12 {
            return None;
        }
        for row in 0..N {
            if row != column {
                let share = rows[row][column] / head;
                let pivot = rows[column];
                for (value, above) in rows[row].iter_mut().zip(pivot) {
                    *value -= share * above;
                }
            }
        }
    }
    Some(std::array::from_fn(|i| rows[i][N] / rows[i][i]))
}
