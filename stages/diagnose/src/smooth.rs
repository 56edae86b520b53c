//! Smooth dependences: small bumps over a covariate (the table, a speed, the order of strikes …) whose heights are Gaussian with one common
//! standard deviation, by marginal likelihood. They stand for what an effect of another form than the library's would leave, and are drawn as maps.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use values::{Point, Strike};
use world::effects::{Experiment, Family, effect};
use world::planar::{Node, Response, StartChange};

use crate::fit::Fitted;
use crate::mixed::{ANGLE, FRICTION, NUISANCES, SPEED};
use crate::score::{ColumnScores, RandomColumns, Replicates, ScoreTest, StrikeColumns};
use crate::sessions::is_by_session;
use crate::strikes::PreparedStrikes;

/// Columns for what a wrong form of the effects held would leave: smooth dependences of their families, each as large as the marginal likelihood
/// would have it. They stand beside a model while it is asked whether it lacks another effect. Friction of its own for each session is no form.
pub(crate) fn family_columns(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
) -> Vec<RandomColumns> {
    let parts = fitted.model.parts.iter();
    let mut covariates: Vec<Covariate> = parts
        .flat_map(|part| {
            let over = family(part.name).iter().copied();
            over.filter(|over| *over != Covariate::Wear || !is_by_session(part.name))
        })
        .collect();
    covariates.sort_unstable();
    covariates.dedup();
    let mut random: Vec<RandomColumns> = Vec::new();
    for covariate in covariates {
        let Some(test) = ScoreTest::new(prepared, fitted, &random, Replicates::NONE) else {
            break;
        };
        let Some(bumps) = bumps(prepared, fitted, &test, covariate) else {
            continue;
        };
        let scores = test.scores(bumps.count(), &bumps.moved);
        let ridge = Ridge::new(&scores, bumps.scale);
        if ridge.variance > 0.0 {
            random.push(RandomColumns {
                moved: bumps.moved,
                variance: ridge.variance,
            });
        }
    }
    random
}

/// What a set of bumps does, and over what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Covariate {
    /// Pushes in both directions, by place on the table.
    Position,
    /// Friction, by place on the table.
    Surface,
    /// Friction, by speed.
    SlidingSpeed,
    /// Friction and a force across the motion, by its direction.
    Heading,
    /// Delivered speed and angle, by the commanded speed, by the commanded angle, and by both together.
    Speed,
    Angle,
    Command,
    /// Delivered speed and angle, by where the object lies.
    Start,
    /// Delivered speed, by the number of strikes before.
    Order,
    /// Delivered angle, by the number of strikes before.
    Turning,
    /// Friction, by the number of strikes before.
    Wear,
}

impl Covariate {
    /// Whether it is one of a strike's launch, or of its friction as a whole.
    pub(crate) fn is_of_whole_strikes(self) -> bool {
        match self {
            Self::Speed
            | Self::Angle
            | Self::Command
            | Self::Start
            | Self::Order
            | Self::Turning
            | Self::Wear => true,
            Self::Position | Self::Surface | Self::SlidingSpeed | Self::Heading => false,
        }
    }
}

/// Over what an effect of another form than the library's would differ from it: what is left of a wrong form lies there.
pub(crate) fn family(name: &str) -> &'static [Covariate] {
    let Ok(spec) = effect(name) else {
        return &[];
    };
    match spec.family {
        Family::FrictionByOrder => &[Covariate::Wear],
        Family::RestitutionByOrder => &[Covariate::Order],
        Family::LaunchAngleByOrder => &[Covariate::Turning],
        Family::FrictionByPlace | Family::FrictionBySlide => &[Covariate::Surface],
        Family::FrictionBySpeed => &[Covariate::SlidingSpeed],
        Family::FrictionByHeading | Family::SeenByHeading => &[Covariate::Heading],
        Family::LaunchByPlace => &[Covariate::Start],
        Family::LaunchSpeed | Family::RestitutionBySpeed => &[Covariate::Speed],
        Family::LaunchAngle => &[Covariate::Angle],
        // Not by commanded speed: bumps over that change the delivered speed too, and would take an arm that saturates.
        Family::LaunchAngleByCommand => &[Covariate::Angle],
        Family::ForceByPlace
        | Family::ForceBySession
        | Family::SeenByPlace
        | Family::SeenBySide => &[Covariate::Position],
    }
}

/// Common heights tried, relative to the bumps' scale.
const HEIGHTS: [f64; 7] = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
/// Information below which the strikes see nothing of a direction.
const SEEN: f64 = 1e-9;

/// Heights of a set of bumps.
pub(crate) struct Ridge {
    /// Variance of the heights; 0 where none is better.
    pub(crate) variance: f64,
    /// Their best values.
    pub(crate) heights: DVector<f64>,
}

impl Ridge {
    /// The best common height, relative to these bumps' scale.
    pub(crate) fn new(scores: &ColumnScores, scale: f64) -> Self {
        let SymmetricEigen {
            eigenvalues,
            eigenvectors,
        } = SymmetricEigen::new(scores.information.clone());
        let projected = eigenvectors.tr_mul(&scores.scores.column(0));
        let seen: Vec<usize> = (0..eigenvalues.len())
            .filter(|i| eigenvalues[*i] > SEEN)
            .collect();
        // Gain in marginal likelihood over no bumps: squares that are taken, less what a common height costs.
        let gain = |variance: f64| -> f64 {
            let each = seen.iter().map(|i| {
                let ratio = eigenvalues[*i] * variance;
                let square = projected[*i].powi(2) / eigenvalues[*i];
                0.5 * (square * ratio / (1.0 + ratio) - ratio.ln_1p())
            });
            each.sum()
        };
        let tried = HEIGHTS.map(|height| (height * scale).powi(2));
        let (_, variance) = tried
            .into_iter()
            .map(|variance| (gain(variance), variance))
            .fold(
                (0.0, 0.0),
                |best, tried| if tried.0 > best.0 { tried } else { best },
            );
        let mut heights = DVector::zeros(scores.alone.len());
        for i in &seen {
            let (l, u) = (eigenvalues[*i], projected[*i]);
            heights += eigenvectors.column(*i) * (u * variance / (1.0 + l * variance));
        }
        Self { variance, heights }
    }
}

/// Distance of bumps on the table in m; their width is the same share of it as for all bumps.
const SPACING: f64 = 0.09;
const WIDTH: f64 = 0.7;
/// Frames within a cell from which a bump stands there, and the most bumps: a wider table has wider bumps.
const FRAMES: usize = 8;
const MOST_CELLS: usize = 60;
/// Bumps along a line, and along each side of the plane of commands.
const BUMPS: usize = 7;
/// Bumps over the speeds or the angles that are commanded: a drive's error may wave along them.
const COMMANDS: usize = 17;
const PLANE: usize = 4;
/// Standard deviation of starts, in m, below which they count as one place.
const STARTS: f64 = 0.005;

/// Typical height of a launch's bumps, relative in speed and in rad.
const LAUNCHES: f64 = 0.01;

/// A bump's place, and the direction in which it acts.
type Place = (Point, Point);

/// The bumps of one covariate.
pub(crate) struct Bumps {
    places: Vec<Place>,
    pub(crate) moved: StrikeColumns,
    /// Typical height.
    pub(crate) scale: f64,
    /// Height, at the second place, of the bump in the middle of which the first place is, on the table or among commands.
    shape: Box<dyn Fn(Point, Point) -> f64 + Send + Sync>,
}

impl Bumps {
    /// Number of bumps.
    pub(crate) fn count(&self) -> usize {
        self.places.len()
    }

    /// Where they stand, each place once.
    pub(crate) fn middles(&self) -> Vec<Point> {
        let mut middles: Vec<Point> = self.places.iter().map(|place| place.0).collect();
        middles.dedup();
        middles
    }

    /// What bumps of these heights do together at a place.
    pub(crate) fn height_at(&self, at: Point, heights: &DVector<f64>) -> Point {
        let each = self.places.iter().zip(heights.iter());
        each.fold(Point::default(), |sum, (place, height)| {
            sum + place.1 * (*height * (self.shape)(place.0, at))
        })
    }
}

/// Height of a bump at a distance from its middle.
fn bump(distance: f64, spacing: f64) -> f64 {
    (-0.5 * (distance / (WIDTH * spacing)).powi(2)).exp()
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    })
}

/// Middles of bumps over a range, and their distance.
fn line(values: impl Iterator<Item = f64>, count: usize) -> (Vec<f64>, f64) {
    let (low, high) = range(values);
    let spacing = ((high - low) / (count - 1) as f64).max(1e-9);
    (
        (0..count).map(|i| low + spacing * i as f64).collect(),
        spacing,
    )
}

/// The bumps of a covariate at a fitted model; `None` where a strike with one does not come to rest.
pub(crate) fn bumps<'a>(
    prepared: &PreparedStrikes<'a>,
    fitted: &Fitted,
    test: &ScoreTest<'_, 'a>,
    covariate: Covariate,
) -> Option<Bumps> {
    let builder = Builder {
        prepared,
        fitted,
        test,
    };
    let strikes = &prepared.strikes;
    let (ahead, left) = (Point::new(1.0, 0.0), Point::new(0.0, 1.0));
    let on_line = |(centres, _): &(Vec<f64>, f64), directions: &[Point]| -> Vec<Place> {
        centres
            .iter()
            .flat_map(|c| directions.iter().map(|d| (Point::new(*c, 0.0), *d)))
            .collect()
    };
    match covariate {
        Covariate::Position | Covariate::Surface => {
            let directions: &[Point] = match covariate {
                Covariate::Position => &[ahead, left],
                _ => &[ahead],
            };
            let mut spacing = SPACING;
            let experiment = Experiment {
                rig: prepared.rig,
                strikes,
            };
            let mut middles = experiment.cells(spacing, FRAMES);
            while middles.len() > MOST_CELLS {
                spacing *= 1.25;
                middles = experiment.cells(spacing, FRAMES);
            }
            let places: Vec<Place> = middles
                .into_iter()
                .flat_map(|c| directions.iter().map(move |d| (c, *d)))
                .collect();
            let is_surface = covariate == Covariate::Surface;
            let acts = if is_surface {
                Acts::OnFriction
            } else {
                Acts::AsForce
            };
            let found = builder.pushed(acts, places, &|(centre, direction), at, v| {
                push(is_surface, direction, v) * bump(at.distance(centre), spacing)
            });
            found.map(|bumps| Bumps {
                shape: Box::new(move |middle, at| bump(at.distance(middle), spacing)),
                ..bumps
            })
        }
        Covariate::SlidingSpeed => {
            let fastest = strikes.iter().map(|s| s.command.speed).fold(0.0, f64::max);
            let speeds = line([0.0, 1.5 * fastest].into_iter(), BUMPS);
            builder.pushed(
                Acts::OnFriction,
                on_line(&speeds, &[ahead]),
                &|(centre, direction), _, v| {
                    push(true, direction, v) * bump(v.norm() - centre.x, speeds.1)
                },
            )
        }
        Covariate::Heading => {
            let headings = line(strikes.iter().map(|s| s.path().bearing()), BUMPS);
            let places = on_line(&headings, &[ahead, left]);
            builder.pushed(Acts::OnFriction, places, &|(centre, direction), _, v| {
                let along = push(true, direction, v);
                let acts = if direction.x > 0.0 {
                    along
                } else {
                    Point::new(-along.y, along.x)
                };
                acts * bump(v.bearing() - centre.x, headings.1)
            })
        }
        Covariate::Wear => {
            let orders = line(strikes.iter().map(|s| s.conditions.order), BUMPS);
            Some(builder.own(on_line(&orders, &[ahead]), 0.05, &|i, place| {
                let height = bump(strikes[i].conditions.order - place.0.x, orders.1);
                [0.0, 0.0, height]
            }))
        }
        Covariate::Order | Covariate::Turning => {
            let orders = line(strikes.iter().map(|s| s.conditions.order), BUMPS);
            let delivered = match covariate {
                Covariate::Order => ahead,
                _ => left,
            };
            Some(
                builder.launched(on_line(&orders, &[delivered]), &|i, place| {
                    bump(strikes[i].conditions.order - place.x, orders.1)
                }),
            )
        }
        Covariate::Speed => {
            let (centres, spacing) = line(strikes.iter().map(|s| s.command.speed), COMMANDS);
            let height = |i: usize, centre: f64| bump(strikes[i].command.speed - centre, spacing);
            let all = 0..strikes.len();
            let mean = |centre: &f64| all.clone().map(|i| height(i, *centre)).sum::<f64>();
            let means: Vec<f64> = centres
                .iter()
                .map(|c| mean(c) / strikes.len() as f64)
                .collect();
            let places = on_line(&(centres.clone(), spacing), &[ahead, left]);
            Some(builder.own(places, LAUNCHES, &|i, (at, direction)| {
                let height = height(i, at.x);
                // No law of speeds turns all strikes alike.
                let mean = centres
                    .iter()
                    .position(|c| *c == at.x)
                    .map_or(0.0, |k| means[k]);
                [direction.x * height, direction.y * (height - mean), 0.0]
            }))
        }
        Covariate::Angle => {
            let angles = line(strikes.iter().map(|s| s.command.angle), COMMANDS);
            Some(
                builder.launched(on_line(&angles, &[ahead, left]), &|i, place| {
                    bump(strikes[i].command.angle - place.x, angles.1)
                }),
            )
        }
        Covariate::Command => Some(builder.on_plane(&|strike| {
            let command = strike.command;
            Point::new(command.speed, command.angle)
        })),
        Covariate::Start => {
            let (_, spread) = Experiment {
                rig: prepared.rig,
                strikes,
            }
            .starts();
            let is_varied = spread.x.max(spread.y) > STARTS;
            is_varied.then(|| builder.on_plane(&|strike| strike.initial))
        }
    }
}

/// Whether a push acts by itself or by friction.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Acts {
    /// A force that is there whatever the friction.
    AsForce,
    /// A change of friction.
    OnFriction,
}

struct Builder<'s, 'f, 'a> {
    prepared: &'f PreparedStrikes<'a>,
    fitted: &'f Fitted,
    test: &'s ScoreTest<'f, 'a>,
}

impl Builder<'_, '_, '_> {
    /// Pushes: `acceleration(place, position, velocity)` at unit height.
    fn pushed(
        &self,
        acts: Acts,
        places: Vec<Place>,
        acceleration: &(dyn Fn(Place, Point, Point) -> Point + Sync),
    ) -> Option<Bumps> {
        let answer = |response: &Response<'_>, _, k: usize, change: &mut [f64]| {
            let place: Place = places[k];
            let added = |node: &Node| node.push(&|at, v| acceleration(place, at, v));
            response.answer(StartChange::default(), &added, change);
        };
        let mut moved = self.test.moved(places.len(), &|_, _| true, &answer);
        if acts == Acts::OnFriction {
            // In shares of each strike's own friction, as the model's friction is: a bump of the same push for all would
            // separate strikes of much friction from those of little, and find the scatter of friction again.
            for (columns, b) in moved.iter_mut().flatten().zip(&self.fitted.nuisances) {
                if let Some(columns) = columns {
                    columns.scale_mut(b[FRICTION].exp());
                }
            }
        }
        moved.map(|moved| Bumps {
            places,
            moved,
            scale: 0.1,
            shape: Box::new(|middle, at| f64::from(middle == at)),
        })
    }

    /// Launches: speed for a place that points ahead, angle for one that points left.
    fn launched(&self, places: Vec<Place>, height: &(dyn Fn(usize, Point) -> f64 + Sync)) -> Bumps {
        self.own(places, LAUNCHES, &|i, place| {
            let height = height(i, place.0);
            [place.1.x * height, place.1.y * height, 0.0]
        })
    }

    /// Launches by bumps on a grid over the plane of `of`, [`PLANE`] along each side.
    fn on_plane(&self, of: &dyn Fn(&Strike) -> Point) -> Bumps {
        let at: Vec<Point> = self.prepared.strikes.iter().map(|s| of(s)).collect();
        let across = line(at.iter().map(|at| at.x), PLANE);
        let along = line(at.iter().map(|at| at.y), PLANE);
        let middles = across
            .0
            .iter()
            .flat_map(|x| along.0.iter().map(|y| Point::new(*x, *y)));
        let directions = [Point::new(1.0, 0.0), Point::new(0.0, 1.0)];
        let places = middles.flat_map(|at| directions.map(|direction| (at, direction)));
        let (wide, high) = (across.1, along.1);
        let shape = move |middle: Point, at: Point| {
            bump(at.x - middle.x, wide) * bump(at.y - middle.y, high)
        };
        let found = self.launched(places.collect(), &|i, place| shape(place, at[i]));
        Bumps {
            shape: Box::new(shape),
            ..found
        }
    }

    /// A strike's own speed, angle and friction, at unit height.
    fn own(
        &self,
        places: Vec<Place>,
        scale: f64,
        shares: &(dyn Fn(usize, &Place) -> [f64; 3] + Sync),
    ) -> Bumps {
        let moved = self.test.launches(&|i| {
            let mut factors = DMatrix::zeros(NUISANCES, places.len());
            for (k, place) in places.iter().enumerate() {
                let [speed, angle, friction] = shares(i, place);
                factors[(SPEED, k)] = speed;
                factors[(ANGLE, k)] = angle;
                factors[(FRICTION, k)] = friction;
            }
            factors
        });
        Bumps {
            places,
            moved,
            scale,
            shape: Box::new(|middle, at| f64::from(middle == at)),
        }
    }
}

/// Ahead or to the left on the table; or against the motion.
fn push(is_friction: bool, direction: Point, velocity: Point) -> Point {
    if is_friction {
        velocity * (-1.0 / velocity.norm().max(1e-6))
    } else {
        direction
    }
}
