//! Scenes that a tracker should not trust: hands, glare, two objects, shadows, borders.

use crate::{Cover, Glare, Moment, Scene, Shade};

/// Numbers of a scene, even over 0 to 1 and the same in every run.
#[derive(Clone, Copy, Debug)]
struct Draw(usize);

impl Draw {
    fn share(self, which: usize) -> f64 {
        // Multiples of irrational numbers fill an interval evenly.
        const STEPS: [f64; 6] = [
            0.618_034, 0.754_878, 0.569_84, 0.445_042, 0.324_718, 0.856_675,
        ];
        (0.13 + (self.0 + 1) as f64 * STEPS[which]).fract()
    }

    fn within(self, which: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share(which)
    }

    fn place(self) -> Moment {
        Moment {
            x: self.within(0, 0.28, 0.76),
            y: self.within(1, -0.30, 0.34),
            yaw: self.within(2, -0.7, 0.7),
        }
    }
}

const SKIN: [f64; 3] = [0.45, 0.20, 0.13];

/// A hand or an arm whose edge runs `over` m past the object's middle towards its far side.
fn hand(at: Moment, draw: Draw, over: f64, colour: [f64; 3]) -> Cover {
    let radius = 0.04;
    let (sin, cos) = draw.within(3, 0.0, std::f64::consts::TAU).sin_cos();
    let tip = [at.x + (radius - over) * cos, at.y + (radius - over) * sin];
    Cover {
        from: tip,
        to: [tip[0] + 0.5 * cos, tip[1] + 0.5 * sin],
        radius,
        height: 0.041,
        colour,
    }
}

/// What is made of a plain scene with the object somewhere, and where the object is.
type Arrange = fn(&mut Scene, Moment, Draw) -> Moment;

/// A kind of scene, how it is arranged, and the reasons that are true of it. Where a centre may be given, it must be right.
#[derive(Debug)]
pub struct Kind {
    /// What it shows.
    pub name: &'static str,
    arrange: Arrange,
    /// Names of the reasons that say what is wrong.
    pub true_of: &'static [&'static str],
    /// Least share of scenes that are refused with such a reason.
    pub least: f64,
}

impl Kind {
    /// Its scene of this number, made from a plain one, and where the object is; far away where there is none.
    pub fn scene(&self, plain: &Scene, number: usize) -> (Scene, Moment) {
        let draw = Draw(number);
        let mut scene = plain.clone();
        let at = (self.arrange)(&mut scene, draw.place(), draw);
        (scene, at)
    }
}

const NONE: [f64; 2] = [9.0, 9.0];

/// All kinds.
pub static KINDS: [Kind; 10] = [
    Kind {
        name: "no object",
        arrange: |_, _, _| Moment {
            x: NONE[0],
            y: NONE[1],
            yaw: 0.0,
        },
        true_of: &["no_object"],
        least: 1.0,
    },
    Kind {
        name: "a hand alone",
        arrange: |scene, at, draw| {
            scene.covers.push(hand(at, draw, 0.0, SKIN));
            Moment {
                x: NONE[0],
                y: NONE[1],
                yaw: 0.0,
            }
        },
        true_of: &["no_object", "shape", "occluded", "border", "shaded"],
        least: 1.0,
    },
    Kind {
        name: "two objects",
        arrange: |scene, at, draw| {
            let (sin, cos) = draw.within(3, 0.0, std::f64::consts::TAU).sin_cos();
            let far = draw.within(4, 0.10, 0.20);
            // Towards the table's middle, where both are seen.
            let other = Moment {
                x: 0.52 + far * cos,
                y: 0.02 + far * sin,
                yaw: 0.3,
            };
            let is_apart = (other.x - at.x).hypot(other.y - at.y) > 0.09;
            let other = if is_apart {
                other
            } else {
                Moment {
                    x: at.x - 0.1,
                    ..at
                }
            };
            scene.others.push(other);
            at
        },
        true_of: &["two_objects"],
        least: 1.0,
    },
    Kind {
        name: "two that touch",
        arrange: |scene, at, draw| {
            let (sin, cos) = draw.within(3, 0.0, std::f64::consts::TAU).sin_cos();
            scene.others.push(Moment {
                x: at.x + 0.062 * cos,
                y: at.y + 0.062 * sin,
                yaw: at.yaw,
            });
            at
        },
        true_of: &["two_objects", "occluded", "shape", "border"],
        least: 0.9,
    },
    Kind {
        name: "cut by the border",
        arrange: |_, at, draw| {
            // The picture ends at about x = −0.06 to 1.04 m at a width of 2.4 mm a pixel.
            let y = if draw.share(4) < 0.5 { -0.76 } else { 0.79 };
            Moment {
                y: y + draw.within(3, -0.025, 0.025),
                ..at
            }
        },
        true_of: &["border", "no_object"],
        least: 0.75,
    },
    Kind {
        name: "a hand over part of it",
        arrange: |scene, at, draw| {
            let over = draw.within(4, -0.015, 0.03);
            scene.covers.push(hand(at, draw, over, SKIN));
            at
        },
        true_of: &["occluded", "shape", "no_object"],
        least: 0.5,
    },
    Kind {
        name: "a grey arm over part of it",
        arrange: |scene, at, draw| {
            let over = draw.within(4, -0.015, 0.03);
            scene.covers.push(hand(at, draw, over, [0.55; 3]));
            at
        },
        true_of: &["occluded", "shape", "no_object"],
        least: 0.5,
    },
    Kind {
        name: "an arm of its colour beside it",
        arrange: |scene, at, draw| {
            let colour = scene.object;
            scene
                .covers
                .push(hand(at, draw, draw.within(4, -0.045, 0.0), colour));
            at
        },
        true_of: &["occluded", "shape", "two_objects", "border"],
        least: 0.5,
    },
    Kind {
        name: "glare",
        arrange: |scene, at, draw| {
            scene.glare = Some(Glare {
                at: [draw.within(3, -0.02, 0.02), draw.within(4, -0.02, 0.02)],
                radius: draw.within(5, 0.022, 0.05),
            });
            at
        },
        true_of: &["saturated", "occluded", "shape", "no_object"],
        least: 0.3,
    },
    Kind {
        name: "a hard, deep shadow's edge over it",
        arrange: |scene, at, draw| {
            let (sin, cos) = draw.within(3, 0.0, std::f64::consts::TAU).sin_cos();
            let off = draw.within(4, -0.02, 0.02);
            scene.shade = Some(Shade {
                at: [at.x + off * cos, at.y + off * sin],
                into: [cos, sin],
                soft: 0.004,
                strength: draw.within(5, 0.8, 0.95),
            });
            at
        },
        true_of: &["shaded", "occluded", "shape", "no_object"],
        least: 0.3,
    },
];
