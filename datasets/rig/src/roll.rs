//! A ball slides until it rolls, then rolls to rest.

use values::Point;

use crate::body::Body;
use crate::motion::{Moment, Motion};
use crate::surface::Surface;

const LONGEST_ROLL: f64 = 30.0;

#[derive(Clone, Copy)]
struct State {
    at: Point,
    velocity: Point,
    /// Surface speed of the ball relative to its centre, opposite to the table: equal to `velocity` when it rolls.
    rolling: Point,
    rolls: bool,
}

/// From a launch without spin to rest. `resistance` is rolling resistance over sliding friction.
pub(crate) fn roll(
    body: &Body,
    surface: &Surface<'_>,
    from: Point,
    velocity: Point,
    resistance: f64,
) -> Motion {
    let step = surface.step(velocity.norm()) / 4.0;
    let mut state = State {
        at: from,
        velocity,
        rolling: Point::default(),
        rolls: false,
    };
    let mut motion = Motion::new(
        step,
        Moment {
            at: from,
            velocity,
            ..Moment::default()
        },
    );
    // A slip of contact decelerates by 1 + r²/k² times friction; 7/2 for a solid ball.
    let Some(radius) = outline_radius(body) else {
        return Motion::still(from, 0.0);
    };
    let gain = radius * radius / body.gyration;
    let mut time = 0.0;
    while time < LONGEST_ROLL {
        let slowing = (resistance * surface.deceleration()).max(1e-6);
        let speed = state.velocity.norm();
        if state.rolls && speed < 1.5 * slowing * step {
            return motion.rest(
                state.at + state.velocity * (0.5 * speed / slowing),
                speed / slowing,
            );
        }
        let slip = state.velocity - state.rolling;
        if !state.rolls && slip.norm() <= (1.0 + gain) * surface.deceleration() * step {
            // The rest of the slip is shared as friction would: k² and r² weigh velocity and rolling.
            let common = (state.velocity * gain + state.rolling) * (1.0 / (1.0 + gain));
            state = State {
                velocity: common,
                rolling: common,
                rolls: true,
                ..state
            };
        }
        state = midpoint(surface, state, time, step, gain, resistance);
        time += step;
        motion.push(Moment {
            at: state.at,
            velocity: state.velocity,
            ..Moment::default()
        });
    }
    motion.rest(state.at, 0.0)
}

fn outline_radius(body: &Body) -> Option<f64> {
    match body.outline {
        crate::body::Outline::Disc(radius) => Some(radius),
        crate::body::Outline::Rectangle(..) => None,
    }
}

fn midpoint(
    surface: &Surface<'_>,
    state: State,
    time: f64,
    step: f64,
    gain: f64,
    resistance: f64,
) -> State {
    let advance = |from: State, at: State, time: f64, step: f64| -> State {
        let pushed = surface.acceleration(at.at, at.velocity, time);
        if at.rolls {
            // A force at the centre of a rolling ball moves it as if it were heavier by k²/r².
            let pulled =
                surface.drag(at.at, at.velocity) * resistance + pushed * (gain / (1.0 + gain));
            let velocity = from.velocity + pulled * step;
            State {
                at: from.at + at.velocity * step,
                velocity,
                rolling: velocity,
                rolls: true,
            }
        } else {
            let drag = surface.drag(at.at, at.velocity - at.rolling);
            State {
                at: from.at + at.velocity * step,
                velocity: from.velocity + (drag + pushed) * step,
                rolling: from.rolling - drag * (gain * step),
                rolls: false,
            }
        }
    };
    let half = advance(state, state, time, step / 2.0);
    advance(state, half, time + step / 2.0, step)
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;
    use crate::effects::GRAVITY;
    use crate::{Hidden, StrikeIndex};

    #[test]
    fn a_ball_keeps_five_sevenths_of_its_speed_and_rolls_to_rest() {
        let body = Body::new(&Rig::demo(Shape::Sphere).object).expect("demo sizes");
        let hidden = Hidden::none();
        let surface = Surface::new(0.25, &hidden, StrikeIndex::default());
        let stop = roll(&body, &surface, Point::default(), Point::new(1.0, 0.0), 0.4).stop();
        let (slide, rolling) = (0.25 * GRAVITY, 0.1 * GRAVITY);
        // It slips until v = 5/7: Δx = (1 − 25/49)/(2 μ g); then (5/7)²/(2 c g).
        let expected = (1.0 - 25.0 / 49.0) / (2.0 * slide) + 25.0 / 49.0 / (2.0 * rolling);
        assert!(
            (stop.x - expected).abs() < 2e-4,
            "{} for {expected}",
            stop.x
        );
    }
}
