//! By how much a predicted launch misses a strike's stop, without another simulation.
//!
//! Distance goes as speed squared and bearing as angle, so that a launch whose speed is off by a factor exp(s), and whose angle by a,
//! stops |exp(2s + ia) − 1| of the path's length from where it should.

use values::{Command, LaunchResidual, Residual, wrap_angle};

/// What a prediction leaves of a strike's launch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Miss {
    /// Error of the speed, as a logarithm.
    speed: f64,
    /// Error of the angle, in rad.
    angle: f64,
}

impl Miss {
    /// The miss of a prediction of what the arm delivers beside the world: logarithm of the factor on the speed, and rad.
    pub(crate) fn of_launch(launch: &LaunchResidual, predicted: [f64; 2]) -> Self {
        Self {
            speed: predicted[0] - launch.speed,
            angle: wrap_angle(predicted[1] - launch.angle),
        }
    }

    /// The miss of a prediction of what to add to the world's command (m/s, rad), where `sent` led along the strike's path; none where no speed would
    /// be left.
    pub(crate) fn of_command(sent: Command, row: &Residual, added: [f64; 2]) -> Option<Self> {
        let speed = row.speed_sim + added[0];
        (speed > 0.0 && sent.speed > 0.0).then(|| Self {
            speed: (sent.speed / speed).ln(),
            angle: wrap_angle(sent.angle - row.angle_sim - added[1]),
        })
    }

    /// Distance between measured and predicted stop, as a share of the path's length.
    pub(crate) fn share(&self) -> f64 {
        let factor = (2.0 * self.speed).exp();
        (factor * self.angle.cos() - 1.0).hypot(factor * self.angle.sin())
    }
}

pub(crate) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Linear between values; none of no numbers.
pub(crate) fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let place = share * (values.len().checked_sub(1)?) as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    Some(values[low] + (place - low as f64) * (values[high] - values[low]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use values::{Point, Split};

    use super::*;

    #[test]
    fn a_launch_that_is_a_tenth_too_fast_stops_a_fifth_too_far_and_a_turned_one_beside() {
        let launch = LaunchResidual {
            speed: 0.0,
            angle: PI - 0.01,
        };
        let fast = Miss::of_launch(&launch, [1.1f64.ln(), PI - 0.01]);
        assert!((fast.share() - 0.21).abs() < 1e-12);
        let turned = Miss::of_launch(&launch, [0.0, -PI + 0.09]);
        assert!((turned.share() - 2.0 * 0.05f64.sin()).abs() < 1e-12);
    }

    #[test]
    fn a_command_that_would_have_been_too_slow_means_a_path_that_is_too_short() {
        let row = Residual {
            strike_id: String::new(),
            path: Point::new(0.3, 0.0),
            speed_sim: 0.7,
            angle_sim: 0.0,
            d_speed: 0.1,
            d_angle: 0.0,
            split: Split::Train,
        };
        let sent = Command::new(0.8, 0.0);
        let exact = Miss::of_command(sent, &row, [0.1, 0.0]).expect("a speed");
        assert!(exact.share() < 1e-12);
        // What was sent stands for a longer path where the residual asks for less.
        let less = Miss::of_command(sent, &row, [0.05, 0.0]).expect("a speed");
        assert!((less.share() - ((0.8f64 / 0.75).powi(2) - 1.0)).abs() < 1e-12);
        assert!(Miss::of_command(sent, &row, [-0.7, 0.0]).is_none());
    }

    #[test]
    fn quantiles_are_linear_between_values() {
        assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile(vec![1.0, 2.0], 0.25), Some(1.25));
        assert_eq!(quantile(Vec::new(), 0.5), None);
    }
}
