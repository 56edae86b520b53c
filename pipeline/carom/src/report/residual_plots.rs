//! Residuals of stops, before and after the effects named, as pictures.

use diagnose::StopResidual;
use plotters::prelude::*;
use values::{Point, Rig, Strike};

use super::plot::{
    Axes, MEASURED, PlotError, axes, colour, line, range, shade_table, svg, view, xy,
};

const MM: f64 = 1000.0;
/// Arrows are drawn so long that this share of the strikes has arrows shorter than [`ARROW`] before.
const USUAL: f64 = 0.9;
/// Length in m of a usual arrow on the table.
const ARROW: f64 = 0.06;
/// Barbs of an arrow: share of its length, and angle from its shaft in rad.
const BARB: (f64, f64) = (0.3, 2.7);

/// A strike and its residual.
pub type StrikeResidual<'a> = (&'a Strike, &'a StopResidual);

/// Which of a strike's residuals is drawn: along and across the simulated path, in m.
pub type ResidualOf = fn(&StopResidual) -> [f64; 2];

/// What a residual is drawn against.
pub struct Covariate {
    /// On the axis.
    pub label: &'static str,
    /// Its value for a strike.
    pub value: fn(&Strike) -> f64,
}

/// All covariates, in the order of the pictures.
pub const COVARIATES: [Covariate; 5] = [
    Covariate {
        label: "commanded speed in m/s",
        value: |strike| strike.command.speed,
    },
    Covariate {
        label: "commanded angle in rad",
        value: |strike| strike.command.angle,
    },
    Covariate {
        label: "x of the stop in m",
        value: |strike| strike.stop.x,
    },
    Covariate {
        label: "y of the stop in m",
        value: |strike| strike.stop.y,
    },
    Covariate {
        label: "strikes before it",
        value: |strike| strike.conditions.order,
    },
];

/// By how much arrows are drawn longer than they are: a power of ten, or two or five of it; never shorter.
pub fn magnification(seen: &[StrikeResidual<'_>]) -> f64 {
    let mut lengths: Vec<f64> = seen
        .iter()
        .map(|(_, look)| look.before[0].hypot(look.before[1]))
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
    model: &str,
    seen: &[StrikeResidual<'_>],
    residual: ResidualOf,
    magnification: f64,
) -> Result<String, PlotError> {
    let size = (560, 500);
    // One view for every map: that of the arrows before.
    let ends = seen.iter().flat_map(|(strike, look)| {
        let (from, by) = arrow(strike, look.before);
        [from, from + by * magnification]
    });
    let (x_range, y_range) = view(ends, size);
    svg(size, |area| {
        let mut chart = axes(
            area,
            &Axes {
                title: super::markup::title(model).as_str(),
                x: "x in m",
                y: "y in m",
                x_range,
                y_range,
            },
        )?;
        shade_table(&mut chart, rig)?;
        for (strike, look) in seen {
            let hue = if look.is_heldout {
                colour(model).mix(1.0)
            } else {
                colour(model).mix(0.45)
            };
            let (from, by) = arrow(strike, residual(look));
            let by = by * magnification;
            let tip = from + by;
            chart.draw_series([line(xy(from), xy(tip), hue.stroke_width(1))])?;
            for side in [-BARB.1, BARB.1] {
                let barb = tip + by.rotated(side) * BARB.0;
                chart.draw_series([line(xy(tip), xy(barb), hue.stroke_width(1))])?;
            }
            chart.draw_series([Circle::new(xy(from), 1, MEASURED.mix(0.6).filled())])?;
        }
        Ok(())
    })
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
    covariate: &Covariate,
    component: usize,
    seen: &[StrikeResidual<'_>],
    models: &[(&str, ResidualOf)],
) -> Result<String, PlotError> {
    let name = ["along in mm", "across in mm"][component];
    svg((250, 210), |area| {
        let values = models.iter().flat_map(|(_, residual)| {
            seen.iter()
                .map(move |(_, look)| MM * residual(look)[component])
        });
        let x_range = range(seen.iter().map(|(strike, _)| (covariate.value)(strike)));
        let mut chart = axes(
            area,
            &Axes {
                title: "",
                x: covariate.label,
                y: name,
                x_range,
                y_range: range(values.chain([0.0])),
            },
        )?;
        chart.draw_series([line((x_range.0, 0.0), (x_range.1, 0.0), MEASURED.mix(0.5))])?;
        for (model, residual) in models {
            let hue = colour(model).mix(0.7);
            chart.draw_series(seen.iter().map(|(strike, look)| {
                let at = ((covariate.value)(strike), MM * residual(look)[component]);
                Circle::new(at, 2, hue.filled())
            }))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Split, Track};

    use super::*;

    fn strike(stop: Point) -> Strike {
        Strike {
            id: "a".into(),
            log: "a.mcap".into(),
            index: 0,
            t_start: 0.0,
            initial: Point::new(0.2, 0.1),
            stop,
            command: Command {
                speed: 0.7,
                angle: 0.1,
            },
            track: Track::default(),
            split: Split::Test,
            conditions: Conditions::default(),
            delivered: None,
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
            magnification(&[(&strike, &look)])
        };
        assert_eq!(
            [of(0.06), of(0.02), of(0.01), of(0.1)],
            [1.0, 2.0, 5.0, 1.0]
        );
    }
}
