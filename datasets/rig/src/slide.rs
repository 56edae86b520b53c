//! A flat-based object slides: x, y and yaw under dry friction integrated over the base.
//!
//! Fixed steps of the classical Runge–Kutta method. Speed and spin of a sliding body end together, so that one event ends
//! the motion: when friction would take both within a step and a half, the rest of the way is that of even deceleration.

use values::Point;

use crate::body::Body;
use crate::motion::{Moment, Motion};
use crate::surface::Surface;

/// No slide lasts so long; a table this slippery or steep has lost its object.
const LONGEST_SLIDE: f64 = 20.0;
/// Steps' worth of deceleration below which the motion counts as ending.
const ENDING: f64 = 1.5;

#[derive(Clone, Copy)]
struct State {
    at: Point,
    yaw: f64,
    velocity: Point,
    spin: f64,
}

/// Rates of position, yaw, velocity and spin.
struct Rate {
    velocity: Point,
    spin: f64,
    acceleration: Point,
    turning: f64,
}

impl State {
    fn after(&self, rate: &Rate, time: f64) -> State {
        State {
            at: self.at + rate.velocity * time,
            yaw: self.yaw + rate.spin * time,
            velocity: self.velocity + rate.acceleration * time,
            spin: self.spin + rate.turning * time,
        }
    }
}

/// Where an object lies, and how it is turned (rad).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lying {
    pub at: Point,
    pub yaw: f64,
}

/// Straight, with a box's faces along the table's axes.
impl From<Point> for Lying {
    fn from(at: Point) -> Self {
        Self { at, yaw: 0.0 }
    }
}

/// Slides from a launch to rest.
pub(crate) fn slide(
    body: &Body,
    surface: &Surface<'_>,
    from: impl Into<Lying>,
    velocity: Point,
    spin: f64,
) -> Motion {
    let step = surface.step(velocity.norm());
    slide_in_steps(body, surface, (from.into(), velocity, spin), step)
}

fn slide_in_steps(
    body: &Body,
    surface: &Surface<'_>,
    (Lying { at, yaw }, velocity, spin): (Lying, Point, f64),
    step: f64,
) -> Motion {
    let mut state = State {
        at,
        yaw,
        velocity,
        spin,
    };
    let mut motion = Motion::new(step, Moment { at, yaw, velocity });
    let radius = body.spread.sqrt();
    let mut time = 0.0;
    while time < LONGEST_SLIDE {
        let speed = state.velocity.norm();
        // Friction here and now, so that a sticky or slippery place ends the motion as it should.
        let slowing = surface.deceleration().max(1e-6) * surface.friction(state.at, speed)
            / surface.friction(state.at, f64::INFINITY).max(1e-9);
        if speed + radius * state.spin.abs() < ENDING * slowing * step {
            return motion.rest(
                state.at + state.velocity * (0.5 * speed / slowing),
                speed / slowing,
            );
        }
        state = runge_kutta(body, surface, state, time, step);
        state.velocity = surface.fenced(state.at, state.velocity, body.reach());
        time += step;
        motion.push(Moment {
            at: state.at,
            yaw: state.yaw,
            velocity: state.velocity,
        });
    }
    motion.rest(state.at, 0.0)
}

fn runge_kutta(body: &Body, surface: &Surface<'_>, state: State, time: f64, step: f64) -> State {
    let k1 = rate(body, surface, &state, time);
    let k2 = rate(
        body,
        surface,
        &state.after(&k1, step / 2.0),
        time + step / 2.0,
    );
    let k3 = rate(
        body,
        surface,
        &state.after(&k2, step / 2.0),
        time + step / 2.0,
    );
    let k4 = rate(body, surface, &state.after(&k3, step), time + step);
    [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)]
        .iter()
        .fold(state, |state, (k, weight)| {
            state.after(k, weight * step / 6.0)
        })
}

fn rate(body: &Body, surface: &Surface<'_>, state: &State, time: f64) -> Rate {
    let (mut force, mut torque) = (Point::default(), 0.0);
    if surface.is_uniform() && state.spin == 0.0 {
        force = surface.drag(state.at, state.velocity);
    } else {
        let (sin, cos) = state.yaw.sin_cos();
        let share = 1.0 / body.elements.len() as f64;
        for element in &body.elements {
            let arm = Point::new(
                cos * element.x - sin * element.y,
                sin * element.x + cos * element.y,
            );
            let velocity = state.velocity + Point::new(-arm.y, arm.x) * state.spin;
            let drag = surface.drag(state.at + arm, velocity) * share;
            force = force + drag;
            torque += arm.x * drag.y - arm.y * drag.x;
        }
    }
    torque -= surface.film() * body.spread * state.spin;
    Rate {
        velocity: state.velocity,
        spin: state.spin,
        acceleration: force + surface.acceleration(state.at, state.velocity, time),
        turning: torque / body.gyration,
    }
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;
    use crate::effects::GRAVITY;
    use crate::{Hidden, StrikeIndex};

    fn body(shape: Shape) -> Body {
        Body::new(&Rig::demo(shape).object).expect("demo sizes")
    }

    #[test]
    fn a_disc_without_spin_stops_after_v_squared_over_two_mu_g() {
        let hidden = Hidden::none();
        let surface = Surface::new(0.25, &hidden, StrikeIndex::default());
        let motion = slide(
            &body(Shape::Cylinder),
            &surface,
            Point::default(),
            Point::polar(1.2, 0.3),
            0.0,
        );
        let distance = 1.2 * 1.2 / (2.0 * 0.25 * GRAVITY);
        assert!(motion.stop().distance(Point::polar(distance, 0.3)) < 1e-9);
        assert!((motion.rest_time() - 1.2 / (0.25 * GRAVITY)).abs() < 1e-9);
        let half = motion.rest_time() / 2.0;
        assert!(motion.at(half).distance(Point::polar(0.75 * distance, 0.3)) < 1e-9);
    }

    #[test]
    fn drag_by_a_film_stops_where_its_formula_says() {
        let hidden = Hidden::parse(&["viscous_drag=0.8"]).expect("valid");
        let surface = Surface::new(0.25, &hidden, StrikeIndex::default());
        let motion = slide(
            &body(Shape::Cylinder),
            &surface,
            Point::default(),
            Point::new(1.0, 0.0),
            0.0,
        );
        // v' = −d − c v from v0: x = v0/c − d/c² ln(1 + c v0/d).
        let (c, d) = (0.8, 0.25 * GRAVITY);
        let expected = 1.0 / c - d / (c * c) * (1.0f64 + c / d).ln();
        assert!(
            (motion.stop().x - expected).abs() < 1e-6,
            "{} {expected}",
            motion.stop().x
        );
    }

    #[test]
    fn steps_ten_times_finer_move_the_stop_by_less_than_a_tenth_of_a_millimetre() {
        let hidden = Hidden::parse(&[
            "demo",
            "friction_patch",
            "table_bowl",
            "anisotropic_friction",
            "sticky_line",
        ])
        .expect("valid");
        let surface = Surface::new(0.25, &hidden, StrikeIndex::default());
        for shape in [Shape::Cylinder, Shape::Box] {
            for (speed, spin) in [(0.6, 3.0), (1.0, 0.0), (1.5, -12.0)] {
                let body = body(shape);
                let launch = (Point::new(0.3, 0.0).into(), Point::polar(speed, 0.2), spin);
                let coarse = slide_in_steps(&body, &surface, launch, surface.step(speed));
                let fine = slide_in_steps(&body, &surface, launch, surface.step(speed) / 10.0);
                let moved = coarse.stop().distance(fine.stop());
                assert!(moved < 5e-5, "{shape:?} at {speed} m/s: {moved}");
            }
        }
    }

    #[test]
    fn a_spinning_disc_slides_farther_than_one_that_does_not_spin() {
        let hidden = Hidden::none();
        let surface = Surface::new(0.25, &hidden, StrikeIndex::default());
        let stop = |spin| {
            slide(
                &body(Shape::Cylinder),
                &surface,
                Point::default(),
                Point::new(1.0, 0.0),
                spin,
            )
            .stop()
            .x
        };
        assert!(stop(30.0) > 1.02 * stop(0.0));
    }
}
