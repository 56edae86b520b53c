//! Strikes as the arm delivered them, where its state was logged.

use crate::Strike;

/// How repeats of one command differ in what the arm delivers: standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArmScatter {
    /// Of the delivered speed, relative.
    pub speed: f64,
    /// Of the delivered angle, in rad.
    pub angle: f64,
}

impl Strike {
    /// The strike with what was delivered in place of what was commanded; `None` where the arm's state was not logged.
    pub fn as_delivered(&self) -> Option<Self> {
        let delivered = self.delivered?;
        Some(Self {
            command: delivered.command(),
            ..self.clone()
        })
    }
}

/// Strikes with what was delivered in place of what was commanded, those left out of which that is not known; `None` where it is
/// known of fewer than half.
pub fn delivered_strikes(strikes: &[Strike]) -> Option<Vec<Strike>> {
    let delivered: Vec<Strike> = strikes.iter().filter_map(Strike::as_delivered).collect();
    (!delivered.is_empty() && 2 * delivered.len() >= strikes.len()).then_some(delivered)
}

/// Scatter of launches under equal commands: by how much delivered speeds (relative) and angles (rad) differ from lines over the
/// commanded ones.
pub fn arm_scatter(strikes: &[Strike]) -> ArmScatter {
    let pairs = || {
        strikes
            .iter()
            .filter_map(|strike| Some((strike.command, strike.delivered?)))
    };
    let speed = about_a_line(pairs().map(|(command, delivered)| {
        (
            command.speed,
            delivered.tip_speed / command.speed.max(1e-9) - 1.0,
        )
    }));
    let turn = std::f64::consts::TAU;
    let angle = about_a_line(pairs().map(|(command, delivered)| {
        let error = delivered.tip_angle - command.angle;
        (command.angle, error - turn * (error / turn).round())
    }));
    ArmScatter { speed, angle }
}

/// Standard deviation about the line of least squares; 0 for too few points.
fn about_a_line(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<(f64, f64)> = points.collect();
    let n = points.len() as f64;
    if points.len() < 3 {
        return 0.0;
    }
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (xx, xy, yy) = points.iter().fold((0.0, 0.0, 0.0), |s, p| {
        let (dx, dy) = (p.0 - x, p.1 - y);
        (s.0 + dx * dx, s.1 + dx * dy, s.2 + dy * dy)
    });
    let explained = if xx > 0.0 { xy * xy / xx } else { 0.0 };
    ((yy - explained).max(0.0) / (n - 2.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Command, Delivered, Point};

    fn strike(i: u32, is_logged: bool) -> Strike {
        let command = Command::new(0.5 + 0.01 * f64::from(i), 0.3 - 0.02 * f64::from(i));
        // A share of 0.9 and a turn, with 1 % and 2 mrad that alternate.
        let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        Strike {
            id: i.to_string(),
            index: i,
            delivered: is_logged.then_some(Delivered {
                tip_speed: command.speed * (0.9 + 0.01 * sign),
                tip_angle: command.angle + 0.05 + 0.002 * sign,
                contact: 0.0,
                pushed_again: false,
            }),
            ..Strike::bare(command, Point::default(), Point::default())
        }
    }

    #[test]
    fn what_was_delivered_stands_in_for_the_command_where_most_is_known() {
        let half: Vec<Strike> = (0..10).map(|i| strike(i, i.is_multiple_of(2))).collect();
        let delivered = delivered_strikes(&half).expect("half is known");
        assert_eq!(delivered.len(), 5);
        assert!((delivered[0].command.speed - 0.5 * 0.91).abs() < 1e-12);
        let few: Vec<Strike> = (0..10).map(|i| strike(i, i == 3)).collect();
        assert_eq!(delivered_strikes(&few), None);
        assert_eq!(delivered_strikes(&[]), None);
    }

    #[test]
    fn an_arms_scatter_is_what_is_left_beside_its_systematic_error() {
        let strikes: Vec<Strike> = (0..40).map(|i| strike(i, true)).collect();
        let scatter = arm_scatter(&strikes);
        assert!((scatter.speed - 0.01).abs() < 5e-4, "{scatter:?}");
        assert!((scatter.angle - 0.002).abs() < 1e-4, "{scatter:?}");
        assert_eq!(arm_scatter(&[]), ArmScatter::default());
    }
}
