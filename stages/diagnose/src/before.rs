//! What came before each strike in its log: an arm may remember it, an object cool down.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use values::{Command, Point, Strike};

/// Number of strikes before one whose commands count together.
const RECENT: usize = 4;

/// What came before a strike.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct CameBefore {
    /// Time, in s, since the strike before in the same log, where there is one.
    pub pause: Option<f64>,
    /// Its command.
    pub command: Option<Command>,
    /// Where its object lay.
    pub start: Option<Point>,
    /// Mean speed (m/s) and angle (rad) of the commands of some strikes before.
    pub mean: Option<[f64; 2]>,
}

/// What came before each of these strikes, by their ids. A strike whose number is not that after the last one's follows another, which is not here.
pub fn came_before(strikes: &[Strike]) -> BTreeMap<String, CameBefore> {
    let mut logs: BTreeMap<&str, Vec<&Strike>> = BTreeMap::new();
    for strike in strikes {
        logs.entry(&strike.log).or_default().push(strike);
    }
    for strikes in logs.values_mut() {
        strikes.sort_by(|a, b| a.t_start.total_cmp(&b.t_start));
    }
    let number = |strike: &Strike| strike.conditions.order;
    let of_log = |strikes: Vec<&Strike>| {
        let before = |(place, strike): (usize, &&Strike)| {
            let is_near = |other: &&&Strike| number(strike) - number(other) <= RECENT as f64;
            let recent: Vec<&Strike> = strikes[..place].iter().filter(is_near).copied().collect();
            let last = recent.last();
            let last = last.filter(|last| number(strike) - number(last) < 1.5);
            let came = CameBefore {
                pause: last.map(|last| strike.t_start - last.t_start),
                command: last.map(|last| last.command),
                start: last.map(|last| last.initial),
                mean: last.map(|_| mean(&recent)),
            };
            (strike.id.clone(), came)
        };
        strikes.iter().enumerate().map(before).collect::<Vec<_>>()
    };
    logs.into_values().flat_map(of_log).collect()
}

fn mean(strikes: &[&Strike]) -> [f64; 2] {
    let mean = |of: fn(&Strike) -> f64| {
        let sum: f64 = strikes.iter().map(|strike| of(strike)).sum();
        sum / strikes.len() as f64
    };
    [mean(|s| s.command.speed), mean(|s| s.command.angle)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_came_before_is_the_neighbours_alone() {
        let strike = |i: usize| {
            let command = Command::new(0.1 * i as f64, 0.2);
            let start = Point::new(0.3, 0.01 * i as f64);
            let mut strike = Strike::bare(command, start, start);
            strike.id = format!("s{i}");
            strike.t_start = 5.0 * i as f64;
            strike.conditions.order = i as f64;
            strike
        };
        // Strike 3 was rejected.
        let strikes: Vec<Strike> = [5, 4, 2, 1].map(strike).into();
        let came = came_before(&strikes);
        let command = |id: &str| came[id].command.map(|command| command.speed);
        assert_eq!(command("s1"), None);
        assert_eq!(command("s2"), Some(0.1));
        assert_eq!((command("s4"), came["s4"].mean), (None, None));
        let last = came["s5"];
        assert_eq!(
            (last.pause, last.start),
            (Some(5.0), Some(Point::new(0.3, 0.04)))
        );
        let speed = last.mean.expect("three before")[0];
        assert!((speed - 0.7 / 3.0).abs() < 1e-12, "{speed}");
    }
}
