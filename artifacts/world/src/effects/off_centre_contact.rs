//! A tip whose line passes beside the object's centre: the object leaves along the line of centres, and may spin.

use super::{
    Acts, Effect, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    wording,
};

/// Off-centre contact; parameter `offset`: of the tip's line from the object's centre, to the left of the approach.
pub const SPEC: EffectSpec = EffectSpec {
    name: "off_centre_contact",
    parameters: Parameters::Listed(&[EffectParameter::new("offset", "m", [-0.02, 0.02], 0.001)]),
    family: Family::LaunchAngle,
    origin: Origin::Contact,
    equivalent: &["striker_angle_bias", "camera_rotation"],
    contains: &[],
    naming: Naming::Ordinary,
    source: "oblique impact of smooth bodies: the impulse acts along the common normal",
    starts: |_| FitStart::linear(("offset", 0.0005)),
    build: |values, _| {
        Box::new(OffCentreContact {
            offset: values.get("offset"),
        })
    },
    statement: |values| {
        let offset = values.get("offset");
        format!(
            "the tip passes {:.1} mm to the {} of the object's centre",
            1000.0 * offset.abs(),
            wording::side(offset)
        )
    },
};

struct OffCentreContact {
    offset: f64,
}

impl Effect for OffCentreContact {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn tip_offset(&self) -> f64 {
        self.offset
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START};

    #[test]
    fn a_smooth_tip_sends_a_round_object_along_the_line_of_centres() {
        for offset in [-0.004, 0.004] {
            let bench = Bench::with("off_centre_contact", &[("offset", offset)])
                .parameter("tip_friction", 0.0);
            let reach = bench.rig.object.solid.reach() + bench.rig.striker.radius;
            let aside: f64 = -(offset / reach).asin();
            let bearing = (bench.strike(0.9, 0.2).stop - START).bearing();
            // While they touch, the line of centres turns a little further.
            assert!(
                ((bearing - 0.2) / aside - 1.0).abs() < 0.05,
                "{} against {aside}",
                bearing - 0.2
            );
        }
    }
}
