//! What a design runs together: where commands or starts follow the order of strikes, an arm that errs by them and one that drifts do the same
//! to every strike; in one direction a slope and a grain do; from one place, what acts by place and what acts by the time or the way since the launch.

use nalgebra::DVector;
use values::{Point, Rig, Strike};
use world::WorldError;
use world::effects::{AddedEffect, Experiment, Family, build, effect};

use crate::model::Part;

/// Squared correlation with the order of strikes beyond which a covariate and the order are one: it takes four of five parts of what depends on either.
const ONE: f64 = 0.8;

/// Standard deviation of starts (m) below which all strikes begin at one place; so many effects that act together from there are none of them.
const ONE_PLACE: f64 = 0.02;
const STACK: usize = 3;

/// What is one in these strikes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Alias {
    /// Commanded speed and start, each with the order.
    speed: bool,
    start: bool,
    /// All directions, and all places of start.
    is_one_way: bool,
    /// Where all strikes start (m), if that is one place.
    one_place: Option<Point>,
}

impl Alias {
    pub(crate) fn of(rig: &Rig, strikes: &[&Strike]) -> Self {
        let all = |covariate: fn(&Strike) -> f64| {
            DVector::from_iterator(strikes.len(), strikes.iter().map(|s| covariate(s)))
        };
        let order = all(|s| s.conditions.order);
        let of = |covariate: fn(&Strike) -> f64| squared_correlation(&order, &all(covariate)) > ONE;
        let starts = [all(|s| s.initial.x), all(|s| s.initial.y)];
        let middle = Point::new(starts[0].mean(), starts[1].mean());
        let [x, y] = starts.map(|places| places.variance());
        Self {
            speed: of(|s| s.command.speed),
            start: of(|s| s.initial.x) || of(|s| s.initial.y),
            is_one_way: Experiment { rig, strikes }.is_one_way(),
            one_place: (x + y < ONE_PLACE * ONE_PLACE).then_some(middle),
        }
    }

    /// Effects that these strikes cannot tell from this one.
    pub(crate) fn alike(self, name: &str) -> Vec<&'static str> {
        let by_speed = ["striker_speed_error", "speed_dependent_restitution"];
        let drift = "restitution_drift";
        match effect(name).map(|spec| spec.family) {
            Ok(Family::LaunchSpeed | Family::RestitutionBySpeed) if self.speed => vec![drift],
            Ok(Family::LaunchByPlace) if self.start => vec![drift],
            Ok(Family::RestitutionByOrder) => {
                let speed = by_speed.into_iter().filter(|_| self.speed);
                let start = self.start.then_some("striker_error_by_place");
                speed.chain(start).collect()
            }
            Ok(Family::FrictionByHeading) if self.is_one_way => vec!["table_tilt"],
            _ if name == "table_tilt" && self.is_one_way => vec!["anisotropic_friction"],
            _ => Vec::new(),
        }
    }

    /// Whether something that changes along every slide may be behind these effects, for all strikes start at one place: they are many, or a patch of
    /// friction lies there.
    pub(crate) fn is_along_every_slide(self, effects: &[Part]) -> bool {
        let Some(start) = self.one_place else {
            return false;
        };
        let lies_there = |part: &Part| {
            let of = |name| part.parameters.get(name).copied();
            let patch = of("center_x").zip(of("center_y")).zip(of("radius"));
            patch.is_some_and(|((x, y), radius)| start.distance(Point::new(x, y)) < radius)
        };
        let is_patch = |part: &&Part| part.name == "friction_patch";
        effects.len() >= STACK || effects.iter().filter(is_patch).any(lies_there)
    }
}

/// Whether a line is surely curved: the edge of a wide disc is, whose far side no strike met.
pub(crate) fn is_curved(added: &AddedEffect) -> bool {
    let curvature = added.parameters.get("curvature");
    let interval = curvature.and_then(|curvature| curvature.low.zip(curvature.high));
    added.name == "friction_step" && interval.is_some_and(|(low, high)| low * high > 0.0)
}

/// Whether this effect of the arm is one with a drift of the heading, which has no name: it turns launches by angles that follow the order of strikes,
/// whether by the commanded angle, the speed or the start.
pub(crate) fn is_drift_of_heading(
    rig: &Rig,
    strikes: &[&Strike],
    added: &AddedEffect,
) -> Result<bool, WorldError> {
    let order = strikes.iter().map(|strike| strike.conditions.order);
    let order = DVector::from_iterator(strikes.len(), order);
    let turned = turned(rig, strikes, added)?;
    Ok(turned.is_some_and(|turned| squared_correlation(&order, &turned) > ONE))
}

/// By how much an effect that depends on the command or the start turns each launch (rad); none of one that moves stops more by the speed it gives
/// launches, of which a stop moves by twice the share.
pub(crate) fn turned(
    rig: &Rig,
    strikes: &[&Strike],
    added: &AddedEffect,
) -> Result<Option<DVector<f64>>, WorldError> {
    let family = effect(&added.name)?.family;
    if !matches!(family, Family::LaunchAngleByCommand | Family::LaunchByPlace) {
        return Ok(None);
    }
    let arm = build(added, rig)?;
    let differs = strikes.iter().map(|strike| {
        let command = strike.command;
        let delivered = arm.deliver(command, strike.initial, &strike.conditions);
        let faster = delivered.speed / command.speed.max(1e-9) - 1.0;
        (delivered.angle - command.angle, 2.0 * faster)
    });
    let (turned, longer): (Vec<f64>, Vec<f64>) = differs.unzip();
    let (turned, longer) = (DVector::from_vec(turned), DVector::from_vec(longer));
    Ok((turned.variance() > longer.variance()).then_some(turned))
}

/// Squared correlation; none of values that do not vary.
fn squared_correlation(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let (a, b) = (a.add_scalar(-a.mean()), b.add_scalar(-b.mean()));
    let squares = a.norm_squared() * b.norm_squared();
    if squares > 0.0 {
        a.dot(&b).powi(2) / squares
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use values::{Command, Conditions, Shape, Split, Track};

    use super::*;

    fn strikes(command: impl Fn(f64) -> Command, start: impl Fn(f64) -> Point) -> Vec<Strike> {
        (0..20u32)
            .map(|i| Strike {
                id: i.to_string(),
                log: "a.mcap".into(),
                index: i,
                t_start: f64::from(i),
                initial: start(f64::from(i)),
                stop: Point::new(0.9, 0.1),
                command: command(f64::from(i)),
                track: Track::default(),
                split: Split::Train,
                conditions: Conditions {
                    order: f64::from(i),
                    ..Conditions::default()
                },
                delivered: None,
            })
            .collect()
    }

    fn alias(command: impl Fn(f64) -> Command, start: impl Fn(f64) -> Point) -> Alias {
        let strikes = strikes(command, start);
        let rig = Rig::demo(Shape::Cylinder);
        Alias::of(&rig, &strikes.iter().collect::<Vec<_>>())
    }

    #[test]
    fn a_sweep_in_order_is_one_with_a_drift() {
        let mixed = |i: f64| (7.0 * i).rem_euclid(20.0);
        let place = |i: f64| Point::new(0.3 + 0.01 * mixed(i), 0.0);
        let swept = alias(
            |i| Command {
                speed: 0.5 + 0.02 * i,
                angle: 0.03 * mixed(i) - 0.3,
            },
            place,
        );
        assert_eq!(swept.alike("striker_speed_error"), ["restitution_drift"]);
        let by_speed = ["striker_speed_error", "speed_dependent_restitution"];
        assert_eq!(swept.alike("restitution_drift"), by_speed);
        assert!(swept.alike("striker_error_by_place").is_empty());
        let turned = alias(
            |i| Command {
                speed: 0.5 + 0.02 * mixed(i),
                angle: 0.03 * i - 0.3,
            },
            place,
        );
        assert!(turned.alike("restitution_drift").is_empty());
    }

    #[test]
    fn an_arm_whose_turn_follows_the_order_is_one_with_a_heading_that_drifts() {
        let mixed = |i: f64| (7.0 * i).rem_euclid(20.0);
        let rig = Rig::demo(Shape::Cylinder);
        let is_drift = |strikes: &[Strike], name, parameters: &[(&str, f64)]| {
            let added = AddedEffect::fixed(name, parameters);
            let strikes: Vec<&Strike> = strikes.iter().collect();
            is_drift_of_heading(&rig, &strikes, &added).expect("an effect of the library")
        };
        let command = |speed: f64, angle: f64| Command {
            speed: 0.5 + 0.02 * speed,
            angle: 0.03 * angle - 0.3,
        };
        let scattered = |i| Point::new(0.3, 0.01 * mixed(i));
        let by_speed = strikes(|i| command(i, mixed(i)), scattered);
        let by_angle = strikes(|i| command(mixed(i), i), scattered);
        let by_start = strikes(
            |i| command(mixed(i), mixed(i)),
            |i| Point::new(0.3, 0.01 * i),
        );
        let turns = [("gain", 0.2)];
        assert!(is_drift(&by_angle, "striker_angle_error", &turns));
        assert!(!is_drift(&by_speed, "striker_angle_error", &turns));
        assert!(!is_drift(&by_start, "striker_angle_error", &turns));
        let turns = [("gain", 0.0), ("slope", 0.3)];
        assert!(is_drift(&by_speed, "striker_angle_error", &turns));
        assert!(!is_drift(&by_angle, "striker_angle_error", &turns));
        let turns = [("angle_y", 0.3)];
        assert!(is_drift(&by_start, "striker_error_by_place", &turns));
        assert!(!is_drift(&by_speed, "striker_error_by_place", &turns));
        assert!(!is_drift(
            &by_start,
            "striker_error_by_place",
            &[("speed_y", 0.3)]
        ));
        assert!(!is_drift(&by_angle, "striker_angle_bias", &[("bias", 0.1)]));
    }

    #[test]
    fn in_one_direction_a_slope_is_a_grain() {
        let one = |i: f64| Command {
            speed: 0.5 + 0.02 * (7.0 * i).rem_euclid(20.0),
            angle: 0.1,
        };
        let start = |i: f64| Point::new(0.3, 0.01 * i);
        let alias = alias(one, start);
        assert_eq!(alias.alike("table_tilt"), ["anisotropic_friction"]);
        assert_eq!(alias.alike("anisotropic_friction"), ["table_tilt"]);
        assert_eq!(alias.alike("striker_error_by_place"), ["restitution_drift"]);
        assert!(!alias.is_along_every_slide(&[patch(0.3), other(), other()]));
    }

    fn other() -> Part {
        Part {
            name: "camera_lean",
            parameters: BTreeMap::new(),
            free: Vec::new(),
            strengths: Vec::new(),
            within: BTreeMap::new(),
            shrinks_to: None,
        }
    }

    fn patch(x: f64) -> Part {
        let parameters = [("center_x", x), ("center_y", 0.0), ("radius", 0.05)];
        Part {
            name: "friction_patch",
            parameters: parameters.map(|(name, value)| (name.into(), value)).into(),
            ..other()
        }
    }

    #[test]
    fn from_one_place_a_patch_there_and_many_effects_are_what_changes_along_slides() {
        let command = |i: f64| Command {
            speed: 0.5 + 0.02 * (7.0 * i).rem_euclid(20.0),
            angle: 0.03 * i - 0.3,
        };
        let alias = alias(command, |_| Point::new(0.3, 0.0));
        assert!(alias.is_along_every_slide(&[other(), other(), other()]));
        assert!(!alias.is_along_every_slide(&[other(), patch(0.5)]));
        assert!(alias.is_along_every_slide(&[patch(0.32)]));
    }
}
