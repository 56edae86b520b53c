//! Strikes as the arm delivered them, where its state was logged.
//!
//! A reading of what an arm delivered has an error. Where the arm repeats better than it is read, most of what readings differ by is that error, and
//! a launch that is taken as read is worse than one that is taken as commanded. How much of it objects follow is seen in their paths: by that
//! share readings are drawn to what the arm makes of such commands (regression calibration: Carroll, Ruppert, Stefanski and
//! Crainiceanu 2006, chapter 4), so that what is left does not depend on what was read.

use nalgebra::{DMatrix, DVector};

use crate::{Command, Delivered, Split, Strike, median, wrap_angle};

/// How repeats of one command differ in what the arm delivers: standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArmScatter {
    /// Standard deviation of the delivered speed, relative to the commanded.
    pub speed: f64,
    /// Standard deviation of the delivered angle, in rad.
    pub angle: f64,
}

impl Strike {
    /// The delivered speed over the commanded one, as a logarithm, and the delivered angle (rad) beside the commanded one; none where delivery is not
    /// known.
    fn beside_command(&self) -> Option<[f64; 2]> {
        let Delivered {
            tip_speed,
            tip_angle,
            ..
        } = self.delivered?;
        let speed = (tip_speed / self.command.speed.max(1e-9)).max(1e-9).ln();
        Some([speed, wrap_angle(tip_angle - self.command.angle)])
    }

    /// The speed that its path shows over the commanded one, as a logarithm (path length grows as speed squared), and the path's angle (rad) beside
    /// the commanded one; none where it does not rest freely or its path is too short to show a direction.
    fn path_beside_command(&self) -> Option<[f64; 2]> {
        /// A shorter path, in m, has no direction to speak of.
        const LEAST: f64 = 0.02;
        let (path, speed) = (self.path(), self.command.speed.max(1e-9));
        let is_free = self.has_stop() && !self.is_pushed_again() && path.norm() > LEAST;
        is_free.then(|| {
            [
                0.5 * path.norm().ln() - speed.ln(),
                wrap_angle(path.bearing() - self.command.angle),
            ]
        })
    }
}

/// What is known of the launches that an arm delivered.
#[derive(Clone, Debug, PartialEq)]
pub enum Deliveries {
    /// They are known of fewer than half of the strikes.
    Unknown,
    /// What is known of them is wrong: objects go as they were commanded to, and surely not as it says.
    NotFollowed,
    /// Strikes with what was delivered in place of what was commanded, calibrated; those left out of which that is not known.
    Known(Vec<Strike>),
}

impl Deliveries {
    /// What is known of these strikes.
    #[must_use]
    pub fn of(strikes: &[Strike]) -> Self {
        let count = strikes.iter().filter(|s| s.delivered.is_some()).count();
        if count == 0 || 2 * count < strikes.len() {
            return Self::Unknown;
        }
        let each = strikes.iter().zip(calibrated(strikes));
        let known: Vec<(&Strike, Delivered)> = each
            .filter_map(|(strike, delivered)| Some((strike, delivered?)))
            .collect();
        if objects_follow_commands(&known) {
            return Self::NotFollowed;
        }
        let delivered = known.into_iter().map(|(strike, delivered)| Strike {
            command: delivered.command(),
            delivered: Some(delivered),
            ..strike.clone()
        });
        Self::Known(delivered.collect())
    }
}

/// Whether paths are told by commands surely better than by these deliveries, by curves of the second degree, in length or in direction; or differ by
/// so much more than deliveries that these are no launches.
fn objects_follow_commands(known: &[(&Strike, Delivered)]) -> bool {
    /// Difference of logarithms of likelihood from which it is no chance.
    const SURELY: f64 = 10.0;
    /// Deviations of the usual error beyond which a strike went astray, or a reading: few of them speak for neither. And the share that is few.
    const ASTRAY: f64 = 5.0;
    const FEW: f64 = 0.1;
    /// Errors, relative and in rad, below which nothing is resolved.
    const RESOLVED: f64 = 1e-3;
    /// Speeds, as roots of path lengths, and directions differ by as much as launches do, about; never so many times as much, but for standard errors.
    const STEEPEST: f64 = 3.0;
    const ERRORS: f64 = 4.0;
    let paths = known.iter().filter_map(|(strike, delivered)| {
        let path = strike.path_beside_command()?;
        let of = |command: Command| [command.speed.max(1e-9).ln(), command.angle];
        let commanded = of(strike.command);
        let path = [path[0] + commanded[0], path[1] + commanded[1]];
        let [speed, angle] = of(delivered.command());
        let delivered = [speed, commanded[1] + wrap_angle(angle - commanded[1])];
        (strike.split != Split::Test).then_some([path, commanded, delivered])
    });
    let paths: Vec<[[f64; 2]; 3]> = paths.collect();
    (0..2).any(|quantity| {
        let mut paths: Vec<[f64; 3]> = paths.iter().map(|of| of.map(|of| of[quantity])).collect();
        let of = |paths: &[[f64; 3]], which: usize| {
            DVector::from_iterator(paths.len(), paths.iter().map(|of| of[which]))
        };
        let errors = |paths: &[[f64; 3]], by: usize| {
            let (x, y) = (of(paths, by), of(paths, 0));
            let mean = x.mean();
            let curve = DMatrix::from_fn(x.len(), 3, |i, k| (x[i] - mean).powi(k as i32));
            Some(&y - &curve * project(&curve, &y)?)
        };
        let both = |paths: &[[f64; 3]]| Some([errors(paths, 1)?, errors(paths, 2)?]);
        let Some(first) = both(&paths) else {
            return false;
        };
        let most = first.each_ref().map(|errors| ASTRAY * usual(errors));
        let is_astray = |i: usize| (0..2).any(|by| first[by][i].abs() > most[by]);
        let astray: Vec<bool> = (0..paths.len()).map(is_astray).collect();
        let count = astray.iter().filter(|is_astray| **is_astray).count();
        if count as f64 <= FEW * paths.len() as f64 {
            let mut astray = astray.iter();
            paths.retain(|_| astray.next().is_some_and(|is_astray| !is_astray));
        }
        let Some([by_command, by_state]) = both(&paths) else {
            return false;
        };
        let n = paths.len() as f64;
        let variance = |errors: &DVector<f64>| errors.norm_squared() / n + RESOLVED * RESOLVED;
        let likelier = 0.5 * n * (variance(&by_state) / variance(&by_command)).ln();
        let (commanded, delivered, went) = (of(&paths, 1), of(&paths, 2), of(&paths, 0));
        let error = (variance(&by_state) / (n * delivered.variance())).sqrt();
        let steep = slope(&delivered, &went).abs() - ERRORS * error;
        let is_steeper = steep > 2.0 * slope(&commanded, &went).abs();
        likelier > SURELY || steep > STEEPEST && is_steeper
    })
}

/// Coefficients of least squares of `values` over the columns of `design`.
fn project(design: &DMatrix<f64>, values: &DVector<f64>) -> Option<DVector<f64>> {
    let gram = design.tr_mul(design).svd(true, true);
    gram.solve(&design.tr_mul(values), 1e-9).ok()
}

/// Standard deviation of errors by their median, which few that went astray do not move.
fn usual(errors: &DVector<f64>) -> f64 {
    1.4826 * median(errors.iter().map(|e| e.abs()).collect()).unwrap_or_default()
}

/// What the arm delivered in each strike, drawn to what it makes of such commands by what of the differences objects do not follow. The strikes that
/// judge say nothing of it.
pub fn calibrated(strikes: &[Strike]) -> Vec<Option<Delivered>> {
    let known: Vec<&Strike> = strikes.iter().filter(|s| s.delivered.is_some()).collect();
    let mut all: Vec<Option<Delivered>> = strikes.iter().map(|s| s.delivered).collect();
    let basis = basis(&known);
    let learns: Vec<bool> = known.iter().map(|s| s.split != Split::Test).collect();
    for quantity in 0..2 {
        let commanded = known.iter().map(|strike| strike.command);
        let commanded: Vec<f64> = commanded
            .map(|command| [command.speed.max(1e-9).ln(), command.angle][quantity])
            .collect();
        let read = known.iter().filter_map(|strike| strike.beside_command());
        let read: Vec<f64> = read.map(|both| both[quantity]).collect();
        let followed = known.iter().map(|strike| strike.path_beside_command());
        let followed: Vec<Option<f64>> = followed
            .map(|both| both.map(|both| both[quantity]))
            .collect();
        let Some((law, share)) = followed_share(&basis, &commanded, &read, &followed, &learns)
        else {
            continue;
        };
        for ((delivered, read), law) in all.iter_mut().flatten().zip(&read).zip(law.iter()) {
            let drawn = law + share * (read - law);
            match quantity {
                0 => delivered.tip_speed *= (drawn - read).exp(),
                _ => delivered.tip_angle += drawn - read,
            }
        }
    }
    all
}

/// Fewest strikes for each function of the basis.
const FEWEST: usize = 4;

/// Sessions that have levels of their own, at the most; of more, all have one.
const MOST_SESSIONS: usize = 30;

/// What an arm's delivery may depend on: a level for each session, the command, the start and the order, each function a column.
fn basis(known: &[&Strike]) -> DMatrix<f64> {
    let of = |strike: &&Strike| {
        let Strike {
            command,
            initial,
            conditions,
            ..
        } = strike;
        let square = |value: f64| [value, value * value];
        let all = [command.speed, command.angle, conditions.order].map(square);
        let start = [initial.x, initial.y];
        all.into_iter().flatten().chain(start).collect::<Vec<f64>>()
    };
    let mut sessions: Vec<&str> = Vec::new();
    let mut session: Vec<usize> = known
        .iter()
        .map(|strike| {
            let name = strike.conditions.session.as_str();
            let seen = sessions.iter().position(|other| *other == name);
            seen.unwrap_or_else(|| {
                sessions.push(name);
                sessions.len() - 1
            })
        })
        .collect();
    if sessions.len() > MOST_SESSIONS {
        sessions.truncate(1);
        session.fill(0);
    }
    let functions: Vec<Vec<f64>> = known.iter().map(of).collect();
    let width = functions.first().map_or(0, Vec::len);
    let mut basis = DMatrix::from_fn(known.len(), sessions.len() + width, |i, k| {
        match k.checked_sub(sessions.len()) {
            Some(k) => functions[i][k],
            None => f64::from(u8::from(session[i] == k)),
        }
    });
    // Of one scale, so that what is constant is told from what varies.
    for mut column in basis.column_iter_mut().skip(sessions.len()) {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
        let norm = column.norm();
        if norm > 1e-6 * (1.0 + mean.abs()) {
            column /= norm;
        } else {
            column.fill(0.0);
        }
    }
    basis
}

/// What the arm makes of each command, and the share of what it was read to differ from that by which its objects follow; `None` where that may be
/// all, or is not known.
fn followed_share(
    basis: &DMatrix<f64>,
    commanded: &[f64],
    read: &[f64],
    followed: &[Option<f64>],
    learns: &[bool],
) -> Option<(DVector<f64>, f64)> {
    /// Errors beyond so many deviations are another thing's.
    const ASTRAY: f64 = 4.0;
    /// Standard errors by which the share must lie below one.
    const SURELY: f64 = 2.0;
    /// An arm's errors must spread by less than its deliveries, for these to show how paths follow them.
    const SPREAD: f64 = 10.0;
    let learning: Vec<usize> = (0..read.len()).filter(|i| learns[*i]).collect();
    if learning.is_empty() || learning.len() < FEWEST * basis.ncols() {
        return None;
    }
    let at = |rows: &[usize], of: &dyn Fn(usize) -> f64| {
        DVector::from_iterator(rows.len(), rows.iter().map(|i| of(*i)))
    };
    let law = basis * project(&basis.select_rows(&learning), &at(&learning, &|i| read[i]))?;
    let mut rows: Vec<usize> = learning;
    rows.retain(|i| followed[*i].is_some());
    // Paths that went astray are left out, then the rest is fitted anew.
    for round in 0..2 {
        if rows.len() < FEWEST * basis.ncols() {
            return None;
        }
        let path = at(&rows, &|i| followed[i].unwrap_or_default());
        let beside = at(&rows, &|i| read[i] - law[i]);
        let delivered = at(&rows, &|i| commanded[i] + law[i]);
        let follows = slope(&delivered, &(&path + at(&rows, &|i| commanded[i])));
        let design = basis.select_rows(&rows);
        let left = |values: &DVector<f64>| Some(values - &design * project(&design, values)?);
        let (path, beside) = (left(&path)?, left(&beside)?);
        let is_spread = delivered.variance() > SPREAD * SPREAD * beside.variance();
        let beside = beside * if is_spread { follows } else { 1.0 };
        let power = beside.norm_squared();
        let share = path.dot(&beside) / power;
        let errors = &path - &beside * share;
        let freedom = rows.len().saturating_sub(basis.ncols() + 1).max(1) as f64;
        let variance = errors.norm_squared() / freedom;
        if round == 0 {
            let most = ASTRAY * usual(&errors);
            let kept = rows.iter().zip(errors.iter());
            rows = kept
                .filter(|(_, e)| e.abs() <= most)
                .map(|(i, _)| *i)
                .collect();
        } else {
            let error = (variance / power).sqrt();
            let is_less = share.is_finite() && share + SURELY * error < 1.0;
            return is_less.then(|| (law, share.max(0.0)));
        }
    }
    None
}

/// Slope of the line of least squares through points of these coordinates; 1 where it is none.
fn slope(x: &DVector<f64>, y: &DVector<f64>) -> f64 {
    let from = |values: &DVector<f64>| values.add_scalar(-values.mean());
    let (x, y) = (from(x), from(y));
    let slope = x.dot(&y) / x.norm_squared();
    if slope.is_finite() { slope } else { 1.0 }
}

/// Scatter of launches under equal commands: by how much delivered speeds (relative) and angles (rad), calibrated, differ from lines over the
/// commanded ones.
pub fn arm_scatter(strikes: &[Strike]) -> ArmScatter {
    let calibrated = calibrated(strikes);
    let pairs = || {
        let each = strikes.iter().zip(&calibrated);
        each.filter_map(|(strike, delivered)| Some((strike.command, (*delivered)?)))
    };
    let speed = about_a_line(pairs().map(|(command, delivered)| {
        (
            command.speed,
            delivered.tip_speed / command.speed.max(1e-9) - 1.0,
        )
    }));
    let angle = about_a_line(pairs().map(|(command, delivered)| {
        (
            command.angle,
            wrap_angle(delivered.tip_angle - command.angle),
        )
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
        let Deliveries::Known(delivered) = Deliveries::of(&half) else {
            panic!("half is known");
        };
        assert_eq!(delivered.len(), 5);
        assert!((delivered[0].command.speed - 0.5 * 0.91).abs() < 1e-12);
        let few: Vec<Strike> = (0..10).map(|i| strike(i, i == 3)).collect();
        assert_eq!(Deliveries::of(&few), Deliveries::Unknown);
        assert_eq!(Deliveries::of(&[]), Deliveries::Unknown);
    }

    #[test]
    fn a_state_that_objects_do_not_follow_is_not_believed() {
        let of = |change: &dyn Fn(&mut Delivered, Command)| {
            let mut strikes = read(0.005, 0.001);
            for strike in &mut strikes {
                let command = strike.command;
                strike.delivered.iter_mut().for_each(|d| change(d, command));
            }
            Deliveries::of(&strikes)
        };
        let is_known = |deliveries| matches!(deliveries, Deliveries::Known(_));
        assert!(is_known(of(&|_, _| {})));
        // An arm that is slow, that turns, and a state of another scale.
        assert!(is_known(of(&|d, _| d.tip_speed *= 0.8)));
        assert!(is_known(of(&|d, _| d.tip_angle *= 0.9)));
        // Cut off at the speed of most, mirrored, and read once in a while.
        let cut = of(&|d, _| d.tip_speed = d.tip_speed.min(0.7));
        assert_eq!(cut, Deliveries::NotFollowed);
        assert_eq!(
            of(&|d, c| d.tip_angle = 0.05 * (40.0 * c.angle).sin()),
            Deliveries::NotFollowed
        );
        assert_eq!(of(&|d, _| d.tip_speed = 0.7), Deliveries::NotFollowed);
        // One reading that is wrong, of too few strikes to calibrate, speaks for nothing.
        let mut one = read(0.005, 0.001);
        one.truncate(30);
        one[7].delivered.iter_mut().for_each(|d| d.tip_speed *= 0.6);
        assert!(is_known(Deliveries::of(&one)));
        // An arm that faces the other way, a little beside its commands.
        let mut turned = read(0.005, 0.001);
        for strike in &mut turned {
            let angle = std::f64::consts::PI + strike.command.angle;
            strike.command.angle = angle;
            strike.stop = Point::polar(strike.stop.norm(), angle + 0.03);
            let read = wrap_angle(angle + 0.03);
            strike.delivered.iter_mut().for_each(|d| d.tip_angle = read);
        }
        assert!(is_known(Deliveries::of(&turned)));
    }

    /// Strikes of an arm that scatters by `arm` about its commands and is read with an error of `read` more, both relative: objects slide as far as
    /// the square of what it truly delivered says, to 0.1 %.
    fn read(arm: f64, read: f64) -> Vec<Strike> {
        // Fractions of multiples of irrational numbers, in units of their standard deviation, of any two independent.
        let even = |i: u32, step: f64| 12f64.sqrt() * ((f64::from(i) * step).fract() - 0.5);
        let strikes = 1..=120u32;
        let each = strikes.map(|i| {
            let command = Command::new(0.7 + 0.1 * even(i, 0.618_033), 0.2 * even(i, 0.414_213));
            let true_speed = command.speed * (1.0 + arm * even(i, 0.732_050));
            let tip_speed = true_speed * (1.0 + read * even(i, 0.236_067));
            let length = 0.4 * true_speed.powi(2) * (1.0 + 0.001 * even(i, 0.302_775));
            let stop = Point::polar(length, command.angle);
            Strike {
                delivered: Some(Delivered {
                    tip_speed,
                    tip_angle: command.angle,
                    contact: 0.0,
                    pushed_again: false,
                }),
                ..Strike::bare(command, Point::default(), stop)
            }
        });
        each.collect()
    }

    #[test]
    fn what_objects_do_not_follow_is_no_delivery() {
        // One part in seventeen of what readings differ by is the arm's.
        let strikes = read(0.001, 0.004);
        let scatter = arm_scatter(&strikes).speed;
        assert!((0.000_1..0.000_8).contains(&scatter), "{scatter}");
        // All of it is.
        let exact = read(0.01, 0.0);
        let read_of =
            |strikes: &[Strike]| -> Vec<_> { strikes.iter().map(|s| s.delivered).collect() };
        assert_eq!(calibrated(&exact), read_of(&exact));
        assert!((arm_scatter(&exact).speed - 0.01).abs() < 1e-3);
        // Strikes that judge say nothing of it.
        let mut judged = read(0.001, 0.004);
        judged
            .iter_mut()
            .for_each(|strike| strike.split = Split::Test);
        assert_eq!(calibrated(&judged), read_of(&judged));
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
