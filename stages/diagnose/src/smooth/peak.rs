//! Where a dependence is strongest, net of what the model's own values make up for.

use nalgebra::DVector;
use values::{Point, Strike};
use world::GRAVITY;

use super::{
    bumps::{Bumps, bump},
    covariate::Covariate,
};
use crate::{
    model::FRICTION,
    score::{ColumnScores, ScoreTest},
    strikes::PreparedStrikes,
};

/// A bump that these strikes see less than this share of the best seen is not spoken of.
const SEEN: f64 = 0.1;

/// Where a covariate's bumps act most strongly, and how strongly there.
pub(super) struct Peak<'s, 'f, 'a> {
    pub(super) prepared: &'f PreparedStrikes<'a>,
    pub(super) test: &'s ScoreTest<'f, 'a>,
}

impl Peak<'_, '_, '_> {
    /// Where a covariate's bumps act most strongly, and how strongly there, net of what the model's own values make up for.
    pub(super) fn strongest(
        &self,
        covariate: Covariate,
        scores: &ColumnScores,
        bumps: &Bumps,
        heights: &DVector<f64>,
    ) -> (Point, Point) {
        let places = &bumps.places;
        let change = -scores.made_up.tr_mul(heights);
        let spacing = places
            .iter()
            .map(|place| place.0.distance(places[0].0))
            .filter(|distance| *distance > 1e-9)
            .fold(f64::INFINITY, f64::min);
        // Bumps overlap: what acts at the middle of one is a sum over its neighbours.
        let on_plane = |at: Point| bumps.height_at(at, heights);
        let bumps = |at: Point| {
            let each = places.iter().zip(heights.iter());
            each.fold(Point::default(), |sum, (place, height)| {
                sum + place.1 * (*height * bump(at.distance(place.0), spacing))
            })
        };
        let strikes = &self.prepared.strikes;
        let launched = |sum: &dyn Fn(Point) -> Point, of: &dyn Fn(&Strike) -> Point| {
            let made_up = self.test.as_launches(&change);
            let by_strike: Vec<(Point, Point)> = strikes
                .iter()
                .zip(made_up)
                .map(|(strike, made_up)| {
                    let at = of(strike);
                    (at, sum(at) + made_up)
                })
                .collect();
            move |at: Point| {
                let near = by_strike
                    .iter()
                    .map(|(place, net)| (bump(at.distance(*place), spacing), *net));
                let (weights, sum) = near.fold((0.0, Point::default()), |(w, s), (weight, net)| {
                    (w + weight, s + net * weight)
                });
                sum * (1.0 / f64::max(weights, 1e-9))
            }
        };
        let on_line = |at: f64| Point::new(at, 0.0);
        let slower = GRAVITY * change[FRICTION];
        let ahead = strikes
            .iter()
            .map(|strike| strike.path())
            .map(|path| path * (1.0 / path.norm().max(1e-9)))
            .fold(Point::default(), |sum, p| {
                sum + p * (1.0 / strikes.len() as f64)
            });
        let net: Box<dyn Fn(Point) -> Point> = match covariate {
            Covariate::Position | Covariate::Phase => Box::new(|at| bumps(at) + ahead * -slower),
            Covariate::Sideways => Box::new(bumps),
            Covariate::Surface | Covariate::SlidingSpeed | Covariate::Heading => {
                Box::new(|at| bumps(at) + Point::new(slower, 0.0))
            }
            // Relative friction, not m/s².
            Covariate::Wear => Box::new(bumps),
            Covariate::Command => Box::new(on_plane),
            Covariate::Start => Box::new(launched(&on_plane, &|strike| strike.initial)),
            Covariate::Order => {
                Box::new(launched(&bumps, &|strike| on_line(strike.conditions.order)))
            }
            Covariate::Speed => Box::new(launched(&bumps, &|strike| on_line(strike.command.speed))),
            Covariate::Angle => Box::new(launched(&bumps, &|strike| on_line(strike.command.angle))),
        };
        let seen = scores.alone.iter().copied().fold(0.0, f64::max);
        places
            .iter()
            .zip(&scores.alone)
            .filter(|(_, alone)| **alone > SEEN * seen)
            .map(|(place, _)| (place.0, net(place.0)))
            .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))
            .unwrap_or_default()
    }
}
