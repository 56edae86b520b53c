//! Residuals of stops, before and after the effects named, as pictures.

use diagnose::StopResidual;
use values::{Point, Rig, Strike};

use super::figures::table_of;
use super::markup::{in_colours, title};
use super::plot::{Kind, Plot, Series};

const MM: f64 = 1000.0;
/// Arrows are drawn so long that this share of the strikes has arrows shorter than [`ARROW`] before.
const USUAL: f64 = 0.9;
/// Length in m of a usual arrow on the table.
const ARROW: f64 = 0.06;

/// A strike with its place among the run's, and its residual.
pub type StrikeResidual<'a> = (usize, &'a Strike, &'a StopResidual);

/// Which of a strike's residuals is drawn: along and across the simulated path, in m.
pub type ResidualOf = fn(&StopResidual) -> [f64; 2];

/// What a residual is drawn against: what stands on the axis, and its value for a strike.
pub type Covariate = (&'static str, fn(&Strike) -> f64);

/// All covariates, in the order of the pictures.
pub const COVARIATES: [Covariate; 5] = [
    ("commanded speed in m/s", |strike| strike.command.speed),
    ("commanded angle in rad", |strike| strike.command.angle),
    ("x of the stop in m", |strike| strike.stop.x),
    ("y of the stop in m", |strike| strike.stop.y),
    ("strikes before it", |strike| strike.conditions.order),
];

/// By how much arrows are drawn longer than they are: a power of ten, or two or five of it; never shorter.
pub fn magnification(seen: &[StrikeResidual<'_>]) -> f64 {
    let mut lengths: Vec<f64> = seen
        .iter()
        .map(|(_, _, look)| look.before[0].hypot(look.before[1]))
        .collect();
    lengths.sort_by(f64::total_cmp);
    let place = (USUAL * lengths.len() as f64) as usize;
    let usual = lengths.get(place).or(lengths.last()).copied();
    let wanted = (ARROW / usual.unwrap_or(ARROW).max(1e-6)).max(1.0);
    let power = 10f64.powf(wanted.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    let step = steps.into_iter().find(|step| step * power <= wanted);
    step.unwrap_or(1.0) * power
}

/// Each strike's residual as an arrow that ends `magnification` times beyond where the world says that it stops.
pub fn map(
    rig: &Rig,
    model: &'static str,
    seen: &[StrikeResidual<'_>],
    residual: ResidualOf,
    magnification: f64,
) -> Plot {
    let arrows = |held_out: bool| {
        let of = seen
            .iter()
            .filter(move |(_, _, look)| look.is_heldout == held_out);
        of.map(move |(place, strike, look)| {
            let (from, by) = arrow(strike, residual(look));
            (*place, [from, from + by * magnification])
        })
    };
    let hue = in_colours(model);
    Plot {
        shaded: table_of(rig),
        ..Plot::map(vec![
            Series::arrows("took part in fit and choice", hue, arrows(false)).pale(),
            Series::arrows("held out", hue, arrows(true)),
        ])
        .titled(title(model))
    }
}

/// Where the world says that the strike stops, and from there to the measured stop, in m. `residual` lies along and across
/// the world's path, whose direction follows from it and the measured path.
fn arrow(strike: &Strike, [along, across]: [f64; 2]) -> (Point, Point) {
    let path = strike.path();
    let turned = (across / path.norm().max(1e-9)).clamp(-1.0, 1.0).asin();
    let by = Point::new(along, across).rotated(path.bearing() - turned);
    (strike.stop - by, by)
}

/// One component of the residuals against a covariate, in mm, model by model; a point a strike.
pub fn against(
    (label, value): Covariate,
    component: usize,
    seen: &[StrikeResidual<'_>],
    models: &[(&'static str, ResidualOf)],
) -> Plot {
    let series = models.iter().map(|(model, residual)| {
        let points = seen.iter().map(|(place, strike, look)| {
            let at = (value(strike), MM * residual(look)[component]);
            (*place, at)
        });
        Series::of_strikes(None, in_colours(model), Kind::Dots, points)
    });
    let y = ["along in mm", "across in mm"][component];
    Plot::new(label, y, series.collect())
}

#[cfg(test)]
mod tests {
    use values::{Command, Split};

    use super::*;

    fn strike(stop: Point) -> Strike {
        Strike {
            id: "a".into(),
            log: "a.mcap".into(),
            split: Split::Test,
            ..Strike::bare(Command::new(0.7, 0.1), Point::new(0.2, 0.1), stop)
        }
    }

    #[test]
    fn an_arrow_leads_from_the_simulated_stop_to_the_measured_one() {
        let initial = Point::new(0.2, 0.1);
        for (simulated, measured) in [
            (Point::new(0.6, 0.2), Point::new(0.63, 0.17)),
            (Point::new(-0.3, 0.4), Point::new(-0.28, 0.35)),
        ] {
            let direction = Point::polar(1.0, (simulated - initial).bearing());
            let by = measured - simulated;
            let residual = [by.dot(direction), direction.x * by.y - direction.y * by.x];
            let (from, arrow) = arrow(&strike(measured), residual);
            assert!(from.distance(simulated) < 1e-12, "{from:?}");
            assert!(arrow.distance(by) < 1e-12, "{arrow:?}");
        }
    }

    #[test]
    fn arrows_are_magnified_in_round_steps() {
        let strike = strike(Point::new(0.6, 0.1));
        let of = |length: f64| {
            let look = StopResidual {
                strike_id: "a".into(),
                is_heldout: true,
                before: [length, 0.0],
                after: [0.0, 0.0],
            };
            magnification(&[(0, &strike, &look)])
        };
        assert_eq!(
            [of(0.06), of(0.02), of(0.01), of(0.1)],
            [1.0, 2.0, 5.0, 1.0]
        );
    }
}
