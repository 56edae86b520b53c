//! The residual of each strike: the command that was sent, less the command that the world needs for the same path
//! (paper, section 3.4).
//!
//! Δv = v_real − v_sim and Δθ = θ_real − θ_sim, where (v_sim, θ_sim) is the inverse solve's command for the strike's
//! measured path. A strike whose path the world cannot reach has no residual; it is excluded by name, with the solve's
//! status. Rows in = residuals + excluded.

use values::{Residual, Strike, wrap_angle};
use world::{Solution, SolveStatus};

/// A strike without a residual.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcludedStrike {
    /// The strike.
    pub strike_id: String,
    /// How its solve ended.
    pub status: SolveStatus,
    /// Miss of the nearest command, in m; none where no simulation came to rest.
    pub miss: Option<f64>,
}

/// What becomes of all strikes, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResidualTable {
    /// Strikes with a residual.
    pub rows: Vec<Residual>,
    /// Strikes without a residual.
    pub excluded: Vec<ExcludedStrike>,
}

/// The residuals of strikes, each with the solution of its path.
pub fn residuals<'a>(
    solved: impl IntoIterator<Item = (&'a Strike, &'a Solution)>,
) -> ResidualTable {
    let mut all = ResidualTable::default();
    for (strike, solution) in solved {
        if solution.status == SolveStatus::Solved {
            all.rows.push(residual(strike, solution));
        } else {
            all.excluded.push(ExcludedStrike {
                strike_id: strike.id.clone(),
                status: solution.status,
                miss: Some(solution.miss).filter(|miss| miss.is_finite()),
            });
        }
    }
    all
}

fn residual(strike: &Strike, solution: &Solution) -> Residual {
    Residual {
        strike_id: strike.id.clone(),
        path: strike.path(),
        speed_sim: solution.command.speed,
        angle_sim: solution.command.angle,
        d_speed: strike.command.speed - solution.command.speed,
        d_angle: wrap_angle(strike.command.angle - solution.command.angle),
        split: strike.split,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use values::{Command, Point, Split};

    use super::*;

    fn strike(id: &str, speed: f64, angle: f64) -> Strike {
        Strike {
            id: id.into(),
            log: "a.mcap".into(),
            split: Split::Validation,
            ..Strike::bare(
                Command { speed, angle },
                Point::new(0.3, 0.1),
                Point::new(0.7, -0.1),
            )
        }
    }

    fn solution(speed: f64, angle: f64, status: SolveStatus) -> Solution {
        Solution {
            command: Command { speed, angle },
            miss: 1e-4,
            evaluations: 2,
            status,
        }
    }

    #[test]
    fn a_residual_is_what_was_commanded_less_what_the_world_would_command() {
        let (strike, solution) = (
            strike("a", 0.8, 0.3),
            solution(0.7, 0.25, SolveStatus::Solved),
        );
        let all = residuals([(&strike, &solution)]);
        let [row] = &all.rows[..] else {
            panic!("one row")
        };
        assert!((row.d_speed - 0.1).abs() < 1e-12 && (row.d_angle - 0.05).abs() < 1e-12);
        assert_eq!((row.speed_sim, row.angle_sim), (0.7, 0.25));
        assert!(row.path.distance(Point::new(0.4, -0.2)) < 1e-12);
        assert_eq!(
            (row.strike_id.as_str(), row.split),
            ("a", Split::Validation)
        );
    }

    #[test]
    fn angles_across_the_seam_differ_by_little() {
        let (strike, solution) = (
            strike("a", 0.8, 3.1),
            solution(0.8, -3.1, SolveStatus::Solved),
        );
        let across = residuals([(&strike, &solution)]);
        assert!((across.rows[0].d_angle - (6.2 - TAU)).abs() < 1e-12);
    }

    #[test]
    fn every_strike_is_either_a_row_or_excluded_by_name() {
        let strikes = [
            strike("a", 0.8, 0.0),
            strike("b", 0.8, 0.0),
            strike("c", 0.8, 0.0),
        ];
        let mut diverged = solution(0.5, 0.0, SolveStatus::Diverged);
        diverged.miss = f64::INFINITY;
        let solutions = [
            solution(0.5, 0.0, SolveStatus::Unreachable),
            solution(0.5, 0.0, SolveStatus::Solved),
            diverged,
        ];
        let all = residuals(strikes.iter().zip(&solutions));
        assert_eq!(all.rows.len(), 1);
        let excluded: Vec<_> = all
            .excluded
            .iter()
            .map(|e| (e.strike_id.as_str(), e.status, e.miss))
            .collect();
        assert_eq!(
            excluded,
            [
                ("a", SolveStatus::Unreachable, Some(1e-4)),
                ("c", SolveStatus::Diverged, None)
            ]
        );
    }
}
