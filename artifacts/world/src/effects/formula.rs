//! Effects that act in one place by one formula. Two formulas are given together: of what an effect does, and of the distance in m
//! within which that is smooth ([`Effect::stretch`]).

use values::{Command, Conditions, Point};

use super::action::{Acts, Effect, Slide};

/// A factor on the friction between object and table.
pub(super) fn braking(
    acts: Acts,
    factor: impl Fn(&Slide<'_>) -> f64 + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Braking(acts, factor, |_| f64::INFINITY))
}

/// A factor on the friction between object and table, by where the object is.
pub(super) fn braking_within(
    factor: impl Fn(&Slide<'_>) -> f64 + Send + Sync + 'static,
    stretch: impl Fn(Point) -> f64 + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Braking(Acts::Slide, factor, stretch))
}

/// A force per unit mass, in m/s².
pub(super) fn forcing(
    acts: Acts,
    acceleration: impl Fn(&Slide<'_>) -> Point + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Forcing(acts, acceleration, |_| f64::INFINITY))
}

/// A force per unit mass, in m/s², by where the object is.
pub(super) fn forcing_within(
    acceleration: impl Fn(&Slide<'_>) -> Point + Send + Sync + 'static,
    stretch: impl Fn(Point) -> f64 + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Forcing(Acts::Slide, acceleration, stretch))
}

/// What the arm delivers: of a command, the object's place and the conditions.
pub(super) fn delivering(
    command: impl Fn(Command, Point, &Conditions) -> Command + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Delivering(command))
}

/// A factor on restitution: of the impact speed in m/s and the conditions.
pub(super) fn restoring(
    factor: impl Fn(f64, &Conditions) -> f64 + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Restoring(factor))
}

/// Where the camera sees an object, and the angle (rad) by which it sees it turned.
pub(super) fn seeing(
    turn: f64,
    place: impl Fn(Point) -> Point + Send + Sync + 'static,
) -> Box<dyn Effect> {
    Box::new(Seeing(turn, place))
}

struct Braking<F, S>(Acts, F, S);

impl<F, S> Effect for Braking<F, S>
where
    F: Fn(&Slide<'_>) -> f64 + Send + Sync,
    S: Fn(Point) -> f64 + Send + Sync,
{
    fn acts(&self) -> Acts {
        self.0
    }

    fn friction_factor(&self, slide: &Slide<'_>) -> f64 {
        (self.1)(slide)
    }

    fn stretch(&self, position: Point) -> f64 {
        (self.2)(position)
    }
}

struct Forcing<F, S>(Acts, F, S);

impl<F, S> Effect for Forcing<F, S>
where
    F: Fn(&Slide<'_>) -> Point + Send + Sync,
    S: Fn(Point) -> f64 + Send + Sync,
{
    fn acts(&self) -> Acts {
        self.0
    }

    fn acceleration(&self, slide: &Slide<'_>) -> Point {
        (self.1)(slide)
    }

    fn stretch(&self, position: Point) -> f64 {
        (self.2)(position)
    }
}

struct Delivering<F>(F);

impl<F: Fn(Command, Point, &Conditions) -> Command + Send + Sync> Effect for Delivering<F> {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn deliver(&self, command: Command, from: Point, conditions: &Conditions) -> Command {
        (self.0)(command, from, conditions)
    }
}

struct Restoring<F>(F);

impl<F: Fn(f64, &Conditions) -> f64 + Send + Sync> Effect for Restoring<F> {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn restitution_factor(&self, impact_speed: f64, conditions: &Conditions) -> f64 {
        (self.0)(impact_speed, conditions)
    }
}

struct Seeing<F>(f64, F);

impl<F: Fn(Point) -> Point + Send + Sync> Effect for Seeing<F> {
    fn acts(&self) -> Acts {
        Acts::Camera
    }

    fn seen_turn(&self) -> f64 {
        self.0
    }

    fn observe(&self, point: Point) -> Point {
        (self.1)(point)
    }
}
