//! The tip's measured places beside those of the objects that it strikes: a scale, a displacement, radii.
//!
//! As an object begins to move, the tip's centre lies both radii behind the object's. So the places where tips should be, out of the
//! camera's, are those where they are by the arm, turned and scaled, and displaced: a line in complex numbers. No speed and no angle of a
//! command has to do with it.

use ingest::Meeting;
use values::{Point, Rig};

use crate::finding::{Delay, Finding, LogRead};
use crate::statistics::median;

/// Fewer places say nothing.
const FEWEST: usize = 10;
/// Places that lie nearer together than this tell no scale, in m (root mean square).
const APART: f64 = 0.03;
/// Places that fit one line no better than this were not those of a tip that strikes, in m.
const AGREE: f64 = 0.03;
/// Turned farther than this the frames of both are wrong, and headings tell how, in rad.
const TURNED: f64 = 0.3;
/// Another scale, another place and other radii than these, in m, by so many standard errors.
const SCALE: f64 = 0.1;
const AWAY: f64 = 0.03;
const RADII: f64 = 0.004;
const SURE: f64 = 4.0;
/// Robust deviations from which a place is astray.
const ASTRAY: f64 = 4.0;

/// What is wrong with places, scale and sizes.
pub(crate) fn findings(rig: &Rig, logs: &[LogRead<'_>], delay: Option<Delay>) -> Vec<Finding> {
    let meetings: Vec<Meeting> = logs
        .iter()
        .flat_map(|log| &log.seen.meetings)
        .copied()
        .collect();
    let touches: usize = logs.iter().map(|log| log.seen.delays.len()).sum();
    let mut findings = Vec::new();
    let line = Similar::of(rig, &meetings).filter(|line| line.spread < AGREE);
    if let Some(line) = line.filter(|line| line.turn.abs() < TURNED) {
        let [scale, error] = line.scale;
        let is_scaled = (scale - 1.0).abs() > SCALE.max(SURE * error);
        if is_scaled {
            findings.push(Finding::Scaled {
                scale,
                error,
                strikes: line.strikes,
            });
        } else if line.away.norm() > AWAY.max(SURE * line.error()) && 2 * touches < line.strikes {
            findings.push(Finding::Displaced {
                by: line.away,
                strikes: line.strikes,
            });
        }
        if is_scaled {
            return findings;
        }
    }
    let reach = delay.and_then(|delay| Some((delay.reach?, delay.strikes)));
    findings.extend(reach.and_then(|([longer, error], strikes)| {
        let is_sure = longer.abs() > RADII.max(SURE * error);
        is_sure.then_some(Finding::Radii {
            longer,
            error,
            strikes,
        })
    }));
    findings
}

/// Places by the camera as those by the arm, turned and scaled and displaced.
struct Similar {
    /// With its standard error; 1 where places lie together.
    scale: [f64; 2],
    /// In rad.
    turn: f64,
    /// By how much the camera's lie beside the arm's in their middle, in m.
    away: Point,
    /// Root mean square of what the line leaves, in m.
    spread: f64,
    strikes: usize,
}

impl Similar {
    fn of(rig: &Rig, meetings: &[Meeting]) -> Option<Self> {
        let reach = rig.object.solid.reach() + rig.striker.radius;
        let mut pairs: Vec<(Point, Point)> = meetings
            .iter()
            .filter(|m| m.velocity.norm() > 0.0 && m.velocity.is_finite())
            .map(|m| {
                let towards = m.velocity * (1.0 / m.velocity.norm());
                (m.tip, m.object - towards * reach)
            })
            .collect();
        let mut line = None;
        // Once more without those that are astray.
        for _ in 0..2 {
            if pairs.len() < FEWEST {
                return None;
            }
            let (fitted, left) = Self::through(&pairs);
            let usual = 1.4826 * median(left.iter().copied())?;
            let mut index = 0;
            pairs.retain(|_| {
                index += 1;
                left[index - 1] <= ASTRAY * usual
            });
            line = Some(fitted);
        }
        line
    }

    /// Least squares, and the distances that it leaves.
    fn through(pairs: &[(Point, Point)]) -> (Self, Vec<f64>) {
        let n = pairs.len() as f64;
        let mean = pairs
            .iter()
            .fold((Point::default(), Point::default()), |(p, q), pair| {
                (p + pair.0 * (1.0 / n), q + pair.1 * (1.0 / n))
            });
        let (mut along, mut across, mut square) = (0.0, 0.0, 0.0);
        for (p, q) in pairs {
            let (p, q) = (*p - mean.0, *q - mean.1);
            along += p.dot(q);
            across += p.x * q.y - p.y * q.x;
            square += p.dot(p);
        }
        let is_told = (square / n).sqrt() > APART;
        let (scale, turn) = if is_told {
            (along.hypot(across) / square, across.atan2(along))
        } else {
            (1.0, 0.0)
        };
        let left: Vec<f64> = pairs
            .iter()
            .map(|(p, q)| (*q - mean.1).distance((*p - mean.0).rotated(turn) * scale))
            .collect();
        let spread = (left.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
        let error = if is_told { spread / square.sqrt() } else { 0.0 };
        let line = Self {
            scale: [scale, error],
            turn,
            away: mean.1 - mean.0,
            spread,
            strikes: pairs.len(),
        };
        (line, left)
    }

    /// Standard error of the displacement, in m.
    fn error(&self) -> f64 {
        self.spread / (self.strikes as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use ingest::Seen;
    use values::Shape;

    use super::*;

    /// Thirty strikes from all over the table; the camera's places are those of the table, scaled and displaced.
    fn found(scale: f64, by: Point) -> Vec<Finding> {
        let rig = Rig::demo(Shape::Cylinder);
        let reach = rig.object.solid.reach() + rig.striker.radius;
        let meetings = (0..30).map(|i| {
            let part = |k: f64| (f64::from(i) * k).fract();
            let object = Point::new(0.2 + 0.2 * part(0.618), -0.2 + 0.4 * part(0.414));
            let velocity = Point::polar(0.4 + 0.6 * part(0.732), -0.8 + 1.6 * part(0.236));
            let noise = 0.004 * (3.7 * f64::from(i)).sin();
            let away = velocity * ((reach + noise) / velocity.norm());
            Meeting {
                tip: object - away,
                velocity,
                object: object * scale + by,
            }
        });
        let seen = Seen {
            meetings: meetings.collect(),
            ..Seen::default()
        };
        let log = LogRead {
            name: "one.mcap",
            seen: &seen,
            kept: 30,
            rejects: Vec::new(),
        };
        findings(&rig, &[log], None)
    }

    #[test]
    fn places_that_agree_are_not_doubted_and_others_are_known_by_what_they_are() {
        assert_eq!(found(1.0, Point::default()), []);
        for scale in [0.5, 0.8, 1.3] {
            let found = found(scale, Point::new(0.1, 0.0));
            assert!(
                matches!(found[..], [Finding::Scaled { scale: by, .. }] if (by - scale).abs() < 0.05),
                "{found:?}"
            );
        }
        let found = found(1.0, Point::new(0.2, -0.1));
        assert!(
            matches!(found[..], [Finding::Displaced { by, .. }] if by.distance(Point::new(0.2, -0.1)) < 0.01),
            "{found:?}"
        );
    }
}
