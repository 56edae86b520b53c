//! The tip's measured places beside those of the objects that it strikes: a scale, a displacement, radii.
//!
//! As an object begins to move, the tip's centre lies both radii behind the object's. So the places where tips should be, out of the
//! camera's, are those where they are by the arm, turned and scaled, and displaced: a line in complex numbers. No speed and no angle of a
//! command has to do with it.

use ingest::Meeting;
use nalgebra::{SMatrix, SVector};
use values::{Point, Rig};

use crate::finding::{Delay, Finding, LogRead, SCALED};
use crate::statistics::{median, wrapped};

/// Least number of places that say something.
const FEWEST: usize = 10;
/// Spread of places (root mean square), in m, below which they tell no scale.
const APART: f64 = 0.03;
/// Spread of places about one line, in m, from which they were not those of a tip that strikes.
const AGREE: f64 = 0.03;
/// Turn, in rad, from which the frames of both are wrong, and headings tell how.
const TURNED: f64 = 0.3;
/// Least error of the scale (relative), of the place and of the radii (m) that is told, and its least size in standard errors.
const SCALE: f64 = 0.1;
const SCALE_BESIDE: f64 = 0.02;
const AWAY: f64 = 0.03;
const RADII: f64 = 0.004;
const SURE: f64 = 4.0;
/// Distance in m of the frames' origins from which it is told; where the directions of the pushes are seen, nothing of a tip that meets objects aside is
/// in it.
const ORIGINS: f64 = 0.015;
const ORIGINS_BY_PUSHES: f64 = 0.01;
/// Turn in rad of the frames about one another from which it is told.
const TOLD_TURN: f64 = 0.05;
/// Robust deviations from which a place is astray.
const ASTRAY: f64 = 4.0;

/// The findings on places, scale and sizes.
pub(crate) fn findings(rig: &Rig, logs: &[LogRead<'_>], delay: Option<Delay>) -> Vec<Finding> {
    let meetings = meetings(logs);
    let is_round = rig.object.shape().is_round();
    let touches = logs.iter().map(|log| log.seen.delays.len());
    let touches: usize = touches.filter(|_| is_round).sum();
    let reach = rig.object.solid.reach() + rig.striker.radius;
    let misses = |by: Point| by.norm() > reach;
    let line_of = |meetings: &[Meeting]| {
        let line = Similar::of(rig, meetings).filter(|line| line.spread < AGREE);
        // How boxes leave tells little of how frames are turned.
        line.filter(|line| !is_round || line.turn.abs() < TURNED)
    };
    let is_away = |line: &Similar| line.away.norm() > AWAY.max(SURE * line.error());
    let scaled = |line: &Similar, log: Option<&str>| {
        let [scale, error] = line.scale;
        let is_scaled = (scale - 1.0).abs() > SCALE.max(SURE * error);
        is_scaled.then(|| Finding::Scaled {
            log: log.map(str::to_owned),
            scale,
            error,
            strikes: line.strikes,
        })
    };
    if let Some(found) = Origins::pictured(rig, &meetings) {
        return vec![found];
    }
    let all = line_of(&meetings);
    if let Some(found) = all.as_ref().and_then(|line| scaled(line, None)) {
        return vec![found];
    }
    // One of several is not seen in all of them together.
    let of_logs = logs.iter().filter_map(|log| {
        let line = line_of(&self::meetings(std::slice::from_ref(log)))?;
        scaled(&line, Some(log.name))
    });
    let mut findings: Vec<Finding> = of_logs.collect();
    if !findings.is_empty() {
        return findings;
    }
    if !is_round && logs.len() > 1 {
        let of_logs = logs.iter().filter_map(|log| {
            let line = line_of(&self::meetings(std::slice::from_ref(log))).filter(is_away)?;
            let others: Vec<Meeting> = logs
                .iter()
                .filter(|other| other.name != log.name)
                .flat_map(|other| self::meetings(std::slice::from_ref(other)))
                .collect();
            let are_away = line_of(&others).is_some_and(|line| is_away(&line));
            (!are_away).then(|| Finding::DisplacedApart {
                log: log.name.into(),
                strike: None,
                by: line.away,
                error: line.error(),
                strikes: line.strikes,
                misses: misses(line.away),
            })
        });
        findings.extend(of_logs);
        if !findings.is_empty() {
            return findings;
        }
    }
    if let Some(line) = all
        && is_away(&line)
        && 2 * touches < line.strikes
    {
        let (by, turn) = match line.turn.abs() > TOLD_TURN.max(SURE * line.scale[1]) {
            true => (line.by, line.turn),
            false => (line.away, 0.0),
        };
        findings.push(Finding::Displaced {
            by,
            turn,
            away: line.away.norm(),
            strikes: line.strikes,
            misses: misses(line.away),
        });
    }
    if let Some(apart) = Origins::of(rig, logs) {
        let is_told = |f: &Finding| matches!(f, Finding::Displaced { .. });
        if !findings.iter().any(is_told) {
            findings.push(Finding::Displaced {
                by: apart.by,
                turn: apart.turn,
                away: apart.away.norm(),
                strikes: apart.delay.strikes,
                misses: misses(apart.away),
            });
        }
    }
    let reach = delay.and_then(|delay| Some((delay.reach?, delay.strikes)));
    findings.extend(reach.and_then(|([longer, error], strikes)| {
        let is_sure = longer.abs() > RADII.max(SURE * error);
        is_sure.then_some(Finding::Radii {
            longer,
            error,
            strikes,
            by_touch: logs.iter().any(|log| log.seen.is_by_state),
        })
    }));
    findings
}

/// The finding that radii are so wrong that no touch is seen as one, where touches alone tell of strikes. A camera that lies behind sees the object
/// where it was as the tip has gone on: both are nearer by this the faster the tip is.
pub(crate) fn reach(rig: &Rig, logs: &[LogRead<'_>]) -> Option<Finding> {
    /// Error of the radii, in m, with which touches can still be seen; the standard errors that a greater one must have; and the least number of
    /// touches for a line.
    const OFF: f64 = 0.015;
    const ERRORS: f64 = 6.0;
    const HITS: usize = 12;
    let stated = rig.object.solid.radius()? + rig.striker.radius;
    let by_state = logs.iter().filter(|log| log.seen.is_by_state);
    let hits: Vec<(f64, f64)> = by_state
        .flat_map(|log| &log.seen.hits)
        .map(|hit| (hit.speed, hit.apart))
        .collect();
    let line = crate::statistics::line(&hits).filter(|_| hits.len() >= HITS)?;
    let off = (line.at_zero - stated).abs();
    (off > OFF.max(ERRORS * line.at_zero_error)).then_some(Finding::Reach {
        apart: line.at_zero,
        error: line.at_zero_error,
        stated,
        hits: hits.len(),
    })
}

/// The arm's measured velocity where it is not the way that its measured place goes: it is told in another frame.
pub(crate) fn state_frame(logs: &[LogRead<'_>]) -> Option<Finding> {
    /// Slower tips show no way, in m/s; a tip's way bends by less than this in so short a time, in rad.
    const SLOWEST: f64 = 0.1;
    const BENDS: f64 = 0.15;
    let meetings = meetings(logs);
    let way = |m: &Meeting| m.moved.filter(|moved| moved.norm() > SLOWEST);
    let turn = |m: &Meeting| Some(wrapped(m.velocity.bearing() - way(m)?.bearing()).abs());
    let turns: Vec<f64> = meetings.iter().filter_map(turn).collect();
    let strikes = turns.len();
    let beside = median(turns).filter(|beside| strikes >= FEWEST && *beside > BENDS)?;
    Some(Finding::StateFrame { beside, strikes })
}

/// Root mean square distance of places from their mean, in m; none of no places.
fn spread(places: impl ExactSizeIterator<Item = Point> + Clone) -> Option<f64> {
    let share = (places.len() > 0).then(|| 1.0 / places.len() as f64)?;
    let mean = places
        .clone()
        .fold(Point::default(), |sum, place| sum + place * share);
    let square: f64 = places.map(|place| place.distance(mean).powi(2)).sum();
    Some((square * share).sqrt())
}

fn meetings(logs: &[LogRead<'_>]) -> Vec<Meeting> {
    let all = logs.iter().flat_map(|log| &log.seen.meetings);
    let moves = |m: &&Meeting| m.velocity.norm() > 0.0 && m.velocity.is_finite();
    all.filter(moves).copied().collect()
}

/// The camera's frame and the arm's have other origins, or are turned.
///
/// What lies between both centres as an object begins to move is both radii along the tip's heading, what the tip has gone since by a delay,
/// and what the origins lie apart: three lines that headings and speeds tell from one another. Where starts lie apart they tell a turn, too.
/// A round object's alone: a box is met anywhere.
pub(crate) struct Origins {
    /// Place of the arm's origin in the camera's frame, in m, and by how much its frame is turned, in rad.
    pub(crate) by: Point,
    pub(crate) turn: f64,
    /// Mean distance of the camera's places from the arm's, in m.
    pub(crate) away: Point,
    /// The delay and the radii that remain beside it.
    pub(crate) delay: Delay,
}

/// Radii, delay, both coordinates of a displacement, a turn, a scale, and two of what else a picture does.
const TERMS: usize = 8;
type Row = SVector<f64, TERMS>;

/// What a camera may do to the places of a table.
#[derive(Clone, Copy)]
enum Picture {
    Right,
    /// One excess of all lengths.
    Scaled,
    /// Beside it one that grows with the square of the distance from where it looks down: a lens.
    Bent,
    /// Beside it one that grows along a line: a camera that leans.
    Leaning,
}

impl Picture {
    /// How many terms it has.
    fn terms(self) -> usize {
        match self {
            Self::Right => 0,
            Self::Scaled => 1,
            Self::Bent => 2,
            Self::Leaning => 3,
        }
    }

    /// What its terms do, each of one, to a place of the table, of a camera that looks down on `centre`.
    fn of(self, place: Point, centre: Point) -> [Point; 3] {
        let (apart, none) = (place - centre, Point::default());
        match self {
            Self::Right => [none; 3],
            Self::Scaled => [place, none, none],
            Self::Bent => [apart, apart * apart.dot(apart), none],
            Self::Leaning => [apart, apart * -apart.x, apart * -apart.y],
        }
    }
}

/// The terms with standard errors; the spread of a coordinate, and each meeting's distance left.
struct Fitted {
    values: Row,
    errors: Row,
    spread: f64,
    left: Vec<f64>,
}

impl Fitted {
    fn is_turned(&self) -> bool {
        self.values[4].abs() > TOLD_TURN.max(SURE * self.errors[4])
    }
}

impl Origins {
    /// The origins by the logs' meetings; none where they agree, or where these strikes do not tell.
    pub(crate) fn of(rig: &Rig, logs: &[LogRead<'_>]) -> Option<Self> {
        let meetings = meetings(logs);
        let turned = Self::without_astray(rig, &meetings, Some(0.0), Picture::Right)?;
        let (fitted, strikes) = match turned.0.is_turned() {
            true => turned,
            false => Self::without_astray(rig, &meetings, None, Picture::Right)?,
        };
        let Fitted {
            values,
            errors,
            spread,
            ..
        } = fitted;
        let (by, turn) = (Point::new(values[2], values[3]), values[4]);
        let share = 1.0 / meetings.len() as f64;
        let away = meetings.iter().fold(Point::default(), |sum, m| {
            sum + (m.tip.rotated(turn) + by - m.tip) * share
        });
        let is_sure = (2..4).any(|i| values[i].abs() > SURE * errors[i]);
        let least = match meetings.iter().all(|m| m.pushed.is_some()) {
            true => ORIGINS_BY_PUSHES,
            false => ORIGINS,
        };
        let is_told = by.norm() > least && is_sure || turn != 0.0;
        (spread < AGREE && is_told).then_some(Self {
            by,
            turn,
            away,
            delay: Delay {
                seconds: [values[1], errors[1]],
                reach: Some([values[0], errors[0]]),
                strikes,
            },
        })
    }

    /// Place of the arm's origin in the camera's frame, and by how much its frame is turned, where objects leave turned by about as much (rad); none
    /// where the origins lie together, or places say something else.
    pub(crate) fn of_turned(rig: &Rig, logs: &[LogRead<'_>], by: f64) -> Option<(Point, f64)> {
        /// Difference of both turns, in rad, up to which they are one.
        const ONE: f64 = 0.1;
        let (fitted, _) = Self::without_astray(rig, &meetings(logs), Some(by), Picture::Right)?;
        let (origin, turn) = (
            Point::new(fitted.values[2], fitted.values[3]),
            fitted.values[4],
        );
        let is_one = fitted.spread < AGREE && wrapped(turn - by).abs() < ONE;
        let is_told = origin.norm() > ORIGINS
            && (2..4).any(|i| fitted.values[i].abs() > SURE * fitted.errors[i]);
        (is_one && is_told).then_some((origin, turn))
    }

    /// The finding that the camera has another scale, or a picture of several, beside any radii, delay and displacement; none where these strikes do not
    /// tell.
    fn pictured(rig: &Rig, meetings: &[Meeting]) -> Option<Finding> {
        /// Difference in −2 ln L, with what another term costs, from which a picture is of several scales: odds of a hundred to one.
        const SURELY: f64 = 9.2;
        // About one place tips lie around an object by the radii, which a scale would pass for.
        spread(meetings.iter().map(|m| m.object)).filter(|spread| *spread > APART)?;
        let of = |picture| Self::without_astray(rig, meetings, None, picture);
        let (fitted, strikes) = of(Picture::Scaled)?;
        let told = |fitted: &Fitted, least: f64| {
            let (excess, error) = (fitted.values[5], fitted.errors[5]);
            let is_told = excess.abs() > least.max(SURE * error);
            is_told.then_some(Finding::Scaled {
                log: None,
                scale: 1.0 + excess,
                error,
                strikes,
            })
        };
        let plain = told(&fitted, SCALE_BESIDE).filter(|_| fitted.spread < AGREE)?;
        let most = ASTRAY * median(fitted.left.iter().copied())?;
        let criterion = |picture: Picture, of: &Fitted| {
            let squares: f64 = of.left.iter().map(|left| left.min(most).powi(2)).sum();
            let n = meetings.len() as f64;
            let scale = fitted.left.len() as f64 / of.left.len().max(1) as f64;
            n * (squares * scale).ln() + picture.terms() as f64 * n.ln()
        };
        let scaled = criterion(Picture::Scaled, &fitted);
        let others = [Picture::Bent, Picture::Leaning].into_iter();
        let others = others.filter_map(|picture| {
            let fitted = of(picture)?.0;
            Some((criterion(picture, &fitted), fitted))
        });
        let best = others.min_by(|a, b| a.0.total_cmp(&b.0));
        Some(match best.filter(|best| best.0 < scaled - SURELY) {
            // Where it looks down a lens or a lean changes no scale.
            Some((_, fitted)) => told(&fitted, SCALED).unwrap_or(Finding::Bent { strikes }),
            None => plain,
        })
    }

    /// The fit, once more without those that are astray, and how many strikes it is of; with a turn that is about this (rad), where one is given, and
    /// with what a picture of this kind does.
    fn without_astray(
        rig: &Rig,
        meetings: &[Meeting],
        turn: Option<f64>,
        picture: Picture,
    ) -> Option<(Fitted, usize)> {
        let mut meetings = meetings.to_vec();
        let mut fitted: Option<Fitted> = None;
        // A turn is found little by little.
        for _ in 0..if turn.is_some() { 4 } else { 2 } {
            if meetings.len() < FEWEST {
                return None;
            }
            let known = fitted.as_ref().map(|fitted| fitted.values[4]);
            let turn_now = turn.map(|turn| known.unwrap_or(turn));
            let found = Self::through(rig, &meetings, turn_now, picture)?;
            let usual = 1.4826 * median(found.left.iter().copied())?;
            let mut left = found.left.iter();
            if fitted.is_none() || turn.is_none() {
                meetings.retain(|_| left.next().is_some_and(|left| *left <= ASTRAY * usual));
            }
            fitted = Some(found);
        }
        Some((fitted?, meetings.len()))
    }

    /// Least squares of radii, delay and both coordinates of the displacement; with a turn beside one that is known, where that is given, and with what
    /// a picture of this kind does. Of a round object alone.
    fn through(
        rig: &Rig,
        meetings: &[Meeting],
        turn: Option<f64>,
        picture: Picture,
    ) -> Option<Fitted> {
        let reach = rig.object.solid.radius()? + rig.striker.radius;
        let known = turn.unwrap_or(0.0);
        // For each coordinate of a meeting: its terms, and what lies between the centres beyond the radii.
        let rows: Vec<(Row, f64)> = meetings
            .iter()
            .flat_map(|m| {
                let velocity = m.velocity.rotated(known);
                let towards = m.towards(known);
                let tip = m.tip.rotated(known);
                // What turns with the arm's frame.
                let turned = match m.pushed {
                    Some(_) => tip,
                    None => tip + towards * reach,
                };
                let between = m.object - tip - towards * reach - velocity * m.earlier;
                let [scaled, first, second] = picture.of(turned, rig.camera.centre);
                let row =
                    |towards, velocity: f64, x, y, turned, [scaled, first, second]: [f64; 3]| {
                        Row::from([towards, -velocity, x, y, turned, scaled, first, second])
                    };
                [
                    (
                        row(
                            towards.x,
                            velocity.x,
                            1.0,
                            0.0,
                            -turned.y,
                            [scaled.x, first.x, second.x],
                        ),
                        between.x,
                    ),
                    (
                        row(
                            towards.y,
                            velocity.y,
                            0.0,
                            1.0,
                            turned.x,
                            [scaled.y, first.y, second.y],
                        ),
                        between.y,
                    ),
                ]
            })
            .collect();
        let products = rows.iter().map(|(row, _)| row * row.transpose());
        let mut normal: SMatrix<f64, TERMS, TERMS> = products.sum();
        let mut right: Row = rows.iter().map(|(row, value)| row * *value).sum();
        let mut terms = TERMS as f64;
        let asked = (4..TERMS).map(|term| match term {
            4 => (term, turn.is_some()),
            _ => (term, picture.terms() > term - 5),
        });
        for (term, _) in asked.filter(|(_, is_asked)| !is_asked) {
            normal.fill_row(term, 0.0);
            normal.fill_column(term, 0.0);
            (normal[(term, term)], right[term]) = (1.0, 0.0);
            terms -= 1.0;
        }
        let inverse = normal.cholesky()?.inverse();
        let mut values = inverse * right;
        let misfit = |(row, value): &(Row, f64)| value - row.dot(&values);
        let squares: f64 = rows.iter().map(|row| misfit(row).powi(2)).sum();
        let spread = (squares / (rows.len() as f64 - terms).max(1.0)).sqrt();
        let errors = inverse
            .diagonal()
            .map(|variance| spread * variance.max(0.0).sqrt());
        let left = rows
            .chunks(2)
            .map(|pair| misfit(&pair[0]).hypot(misfit(&pair[1])));
        let left = left.collect();
        values[4] += known;
        Some(Fitted {
            values,
            errors,
            spread,
            left,
        })
    }
}

/// Places by the camera as those by the arm, turned and scaled and displaced.
struct Similar {
    /// Scale with its standard error; 1 where places lie together.
    scale: [f64; 2],
    /// Turn of the arm's frame, in rad.
    turn: f64,
    /// By how much the camera's lie beside the arm's in their middle, in m, and where the arm's origin lies by the camera.
    away: Point,
    by: Point,
    /// Root mean square of what the line leaves, in m.
    spread: f64,
    strikes: usize,
}

impl Similar {
    fn of(rig: &Rig, meetings: &[Meeting]) -> Option<Self> {
        let met_at = |m: &Meeting| {
            let towards = m.towards(0.0);
            m.object - towards * (rig.object.solid.outline(towards) + rig.striker.radius)
        };
        let mut pairs: Vec<(Point, Point)> = meetings.iter().map(|m| (m.tip, met_at(m))).collect();
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

    /// Fits by least squares; also gives the distances (m) that it leaves.
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
            by: mean.1 - mean.0.rotated(turn),
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
    use values::{Command, Shape, Solid};

    use super::*;

    /// Thirty strikes from all over the table; the camera's places are those of the table, scaled and displaced.
    fn found(scale: f64, by: Point) -> Vec<Finding> {
        let seen = seen(scale, by, 0.0);
        findings(&Rig::demo(Shape::Cylinder), &[log(&seen)], None)
    }

    fn log(seen: &Seen) -> LogRead<'_> {
        LogRead {
            name: "one.mcap",
            seen,
            kept: 30,
            rejects: Vec::new(),
        }
    }

    fn seen(scale: f64, by: Point, delay: f64) -> Seen {
        let rig = Rig::demo(Shape::Cylinder);
        let reach = rig.object.solid.reach() + rig.striker.radius;
        let meetings = (0..30).map(|i| {
            let part = |k: f64| (f64::from(i) * k).fract();
            let object = Point::new(0.2 + 0.2 * part(0.618), -0.2 + 0.4 * part(0.414));
            let velocity = Point::polar(0.4 + 0.6 * part(0.732), -0.8 + 1.6 * part(0.236));
            let noise = 0.004 * (3.7 * f64::from(i)).sin();
            let away = velocity * ((reach + noise) / velocity.norm());
            Meeting {
                tip: object - away + velocity * delay,
                velocity,
                moved: Some(velocity.rotated(0.02)),
                object: object * scale + by,
                pushed: None,
                earlier: 0.0,
                at: 6.0 * f64::from(i),
                command: Command::new(velocity.norm(), velocity.bearing()),
                delay: None,
                delivered: None,
            }
        });
        Seen {
            meetings: meetings.collect(),
            ..Seen::default()
        }
    }

    #[test]
    fn a_wide_box_that_is_met_at_its_face_is_not_away() {
        let mut rig = Rig::demo(Shape::Box);
        let half = 0.03;
        rig.object.solid = Solid::Box {
            half_size: [half, 0.1, 0.03],
        };
        let away = |displaced: Point| {
            let mut seen = seen(1.0, displaced, 0.0);
            for meeting in &mut seen.meetings {
                let heading = 0.5 * meeting.velocity.bearing();
                meeting.velocity = Point::polar(meeting.velocity.norm(), heading);
                // The tip's centre lies its radius before the face, on its way through the middle.
                let beside = (half + rig.striker.radius) / heading.cos();
                meeting.tip = meeting.object - displaced - Point::polar(beside, heading);
            }
            let found = findings(&rig, &[log(&seen)], None);
            found.iter().any(|f| matches!(f, Finding::Displaced { .. }))
        };
        assert!(!away(Point::default()));
        assert!(away(Point::new(0.05, -0.03)));
    }

    #[test]
    fn a_picture_of_several_scales_is_no_wrong_scale() {
        let rig = Rig::demo(Shape::Cylinder);
        let of = |picture: &dyn Fn(Point) -> Point| {
            let mut seen = seen(1.0, Point::default(), 0.0);
            for meeting in &mut seen.meetings {
                meeting.object = picture(meeting.object);
            }
            findings(&rig, &[log(&seen)], None)
        };
        let centre = rig.camera.centre;
        let bent = of(&|place| {
            let apart = place - centre;
            centre + apart * (1.0 + 0.8 * apart.dot(apart))
        });
        assert!(matches!(bent[..], [Finding::Bent { .. }]), "{bent:?}");
        let leaning = of(&|place| {
            let apart = place - centre;
            centre + apart * (1.0 + 0.3 * apart.x + 0.5 * apart.y).recip()
        });
        assert!(matches!(leaning[..], [Finding::Bent { .. }]), "{leaning:?}");
        let scaled = of(&|place| place * 1.06);
        assert!(matches!(scaled[..], [Finding::Scaled { .. }]), "{scaled:?}");
        // Of both, the scale is what is wrong.
        let both = of(&|place| {
            let apart = place - centre;
            centre + apart * (1.15 / (1.0 + 0.3 * apart.x + 0.5 * apart.y))
        });
        assert!(matches!(both[..], [Finding::Scaled { .. }]), "{both:?}");
    }

    #[test]
    fn one_session_of_another_scale_is_told_by_its_name() {
        let rig = Rig::demo(Shape::Cylinder);
        let seen = [1.0, 1.0, 0.8].map(|scale| seen(scale, Point::default(), 0.0));
        let logs = [0, 1, 2].map(|i| LogRead {
            name: ["one.mcap", "two.mcap", "three.mcap"][i],
            ..log(&seen[i])
        });
        let found = findings(&rig, &logs, None);
        assert!(
            matches!(&found[..], [Finding::Scaled { log: Some(log), .. }] if log == "three.mcap"),
            "{found:?}"
        );
    }

    #[test]
    fn a_scale_is_told_beside_a_delay_and_radii_and_none_where_these_are_all() {
        let rig = Rig::demo(Shape::Cylinder);
        for (scale, delay) in [(1.05, 0.0), (0.95, 0.02), (1.03, -0.01)] {
            let found = findings(&rig, &[log(&seen(scale, Point::default(), delay))], None);
            assert!(
                matches!(&found[..], [Finding::Scaled { scale: told, .. }] if (told - scale).abs() < 0.01),
                "{found:?}"
            );
        }
        let mut longer = rig.clone();
        longer.striker.radius += 0.005;
        for delay in [0.0, 0.03] {
            let found = findings(&longer, &[log(&seen(1.0, Point::default(), delay))], None);
            assert!(
                !found.iter().any(|f| matches!(f, Finding::Scaled { .. })),
                "{found:?}"
            );
        }
    }

    #[test]
    fn other_origins_are_told_from_a_delay_and_from_other_radii() {
        let rig = Rig::demo(Shape::Cylinder);
        for (by, delay) in [
            ((0.05, 0.0), 0.0),
            ((0.05, 0.0), 0.02),
            ((-0.02, 0.03), -0.01),
        ] {
            let by = Point::new(by.0, by.1);
            let seen = seen(1.0, by, delay);
            let found = Origins::of(&rig, &[log(&seen)]).expect("other origins");
            assert!(found.by.distance(by) < 0.005, "{:?}", found.by);
            let Delay { seconds, reach, .. } = found.delay;
            assert!(
                (seconds[0] - delay).abs() < 4.0 * seconds[1] + 1e-3,
                "{seconds:?}"
            );
            assert!(
                reach.is_some_and(|[longer, error]| longer.abs() < 4.0 * error),
                "{reach:?}"
            );
        }
        for delay in [0.0, 0.03] {
            assert!(Origins::of(&rig, &[log(&seen(1.0, Point::default(), delay))]).is_none());
        }
    }

    #[test]
    fn a_turned_frame_is_told_with_the_origin_that_belongs_to_it() {
        let rig = Rig::demo(Shape::Cylinder);
        for (turn, by) in [(0.175, Point::default()), (-0.1, Point::new(0.03, -0.05))] {
            let mut seen = seen(1.0, Point::default(), 0.01);
            for meeting in &mut seen.meetings {
                meeting.object = meeting.object.rotated(turn) + by;
            }
            let found = Origins::of(&rig, &[log(&seen)]).expect("a turned frame");
            assert!((found.turn - turn).abs() < 0.02, "{}", found.turn);
            assert!(found.by.distance(by) < 0.006, "{:?}", found.by);
            assert!(found.away.norm() > 0.02, "{:?}", found.away);
        }
    }

    #[test]
    fn a_turn_that_headings_tell_is_told_with_the_origin_that_belongs_to_it() {
        let rig = Rig::demo(Shape::Cylinder);
        for (turn, by) in [
            (0.524, Point::new(0.03, -0.05)),
            (-1.57, Point::new(0.1, 0.2)),
        ] {
            let mut seen = seen(1.0, Point::default(), 0.01);
            for meeting in &mut seen.meetings {
                meeting.object = meeting.object.rotated(turn) + by;
            }
            let of = |turn: f64| Origins::of_turned(&rig, &[log(&seen)], turn);
            let (origin, told) = of(turn + 0.03).expect("other origins");
            assert!(
                (told - turn).abs() < 0.02 && origin.distance(by) < 0.01,
                "{origin:?}"
            );
            assert_eq!(of(turn + 0.3), None);
        }
        // Where the tip's places are the table's, a turn is the command's own.
        let seen = seen(1.0, Point::default(), 0.01);
        assert_eq!(Origins::of_turned(&rig, &[log(&seen)], 0.524), None);
    }

    #[test]
    fn objects_that_moved_and_were_met_aside_tell_origins_and_delay() {
        let rig = Rig::demo(Shape::Cylinder);
        let reach = rig.object.solid.reach() + rig.striker.radius;
        let (by, delay, earlier) = (Point::new(0.01, -0.03), 0.04, 0.036);
        let meetings = (0..60).map(|i| {
            let part = |k: f64| (f64::from(i) * k).fract();
            let object = Point::new(0.2 + 0.2 * part(0.618), -0.2 + 0.4 * part(0.414));
            let velocity = Point::polar(0.4 + 0.6 * part(0.732), -0.8 + 1.6 * part(0.236));
            let pushed = Point::polar(1.0, velocity.bearing() - 0.7 + 1.4 * part(0.519));
            let noise = Point::new((3.7 * f64::from(i)).sin(), (5.1 * f64::from(i)).sin()) * 0.003;
            Meeting {
                tip: object - pushed * reach + velocity * (delay - earlier) + noise,
                velocity,
                moved: None,
                object: object + by,
                pushed: Some(pushed),
                earlier,
                at: 6.0 * f64::from(i),
                command: Command::new(velocity.norm(), velocity.bearing()),
                delay: None,
                delivered: None,
            }
        });
        let seen = Seen {
            meetings: meetings.collect(),
            ..Seen::default()
        };
        let found = Origins::of(&rig, &[log(&seen)]).expect("other origins");
        assert!(found.by.distance(by) < 0.005, "{:?}", found.by);
        let [seconds, error] = found.delay.seconds;
        assert!((seconds - delay).abs() < 4.0 * error, "{seconds} ± {error}");
    }

    #[test]
    fn a_velocity_in_the_frame_of_the_tool_is_not_the_way_that_the_place_goes() {
        let mut seen = seen(1.0, Point::default(), 0.0);
        assert_eq!(state_frame(&[log(&seen)]), None);
        for meeting in &mut seen.meetings {
            meeting.velocity = Point::new(meeting.velocity.norm(), 0.0);
        }
        let found = state_frame(&[log(&seen)]);
        assert!(
            matches!(found, Some(Finding::StateFrame { beside, strikes: 30 }) if beside > 0.2),
            "{found:?}"
        );
    }

    #[test]
    fn under_boxes_a_turned_frame_is_told_and_so_is_that_of_one_log() {
        let rig = Rig::demo(Shape::Box);
        let turned = |turn: f64| {
            let mut seen = seen(1.0, Point::default(), 0.0);
            for meeting in &mut seen.meetings {
                meeting.object = meeting.object.rotated(turn);
            }
            seen
        };
        let found = findings(&rig, &[log(&turned(0.524))], None);
        assert!(
            matches!(found[..], [Finding::Displaced { turn, misses: true, .. }] if (turn - 0.524).abs() < 0.05),
            "{found:?}"
        );
        for turn in [0.14, 0.524] {
            let seen = [0.0, 0.0, turn].map(turned);
            let logs = [0, 1, 2].map(|i| LogRead {
                name: ["one.mcap", "two.mcap", "three.mcap"][i],
                ..log(&seen[i])
            });
            assert_eq!(findings(&rig, &logs[..2], None), []);
            let found = findings(&rig, &logs, None);
            assert!(
                matches!(&found[..], [Finding::DisplacedApart { log, strike: None, misses, .. }]
                    if log == "three.mcap" && *misses == (turn > 0.5)),
                "{found:?}"
            );
        }
    }

    #[test]
    fn strikes_from_one_place_tell_no_scale() {
        let mut seen = seen(1.0, Point::default(), 0.0);
        for (i, meeting) in seen.meetings.iter_mut().enumerate() {
            let at = Point::new(0.3, 0.001 * (7.1 * i as f64).sin());
            // The tip's place is read with an error, too.
            let error = Point::new((3.3 * i as f64).sin(), (4.7 * i as f64).sin()) * 0.002;
            meeting.tip = meeting.tip + (at - meeting.object) + error;
            meeting.object = at;
        }
        let found = findings(&Rig::demo(Shape::Cylinder), &[log(&seen)], None);
        assert_eq!(found, []);
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
