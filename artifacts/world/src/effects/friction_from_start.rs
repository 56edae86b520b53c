//! Friction that is another at the beginning of each slide, wherever that is: an object that stuck to the table while it lay there, one that the
//! strike lifts or drives into it, a film of air or oil that is pressed out. It is stated, and never named: it belongs to the object, not to a place.
//!
//! Friction is (1 + change·e^(−s/length)) times as high, s the distance from where the object was struck.

use super::{
    Acts, Column, EffectParameter, EffectSpec, Family, FitStart, Naming, Origin, Parameters,
    formula::braking, wording,
};

/// Lengths (m) that are tried.
const LENGTHS: [f64; 4] = [0.02, 0.05, 0.12, 0.3];

/// Friction from the start on; parameters `change`: relative, where the object was struck; `length`: over which it falls to 1/e.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_from_start",
    parameters: Parameters::Listed(&[
        EffectParameter::new("change", "", [-0.98, 10.0], 0.3),
        EffectParameter::new("length", "m", [0.005, 1.0], 0.05).neutral_at(0.05),
    ]),
    family: Family::FrictionBySlide,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "friction that ages while surfaces rest on each other (Dieterich 1979), and is renewed over a length of slip; films that are pressed out",
    starts: |_| {
        let each = LENGTHS.map(|length| Column::new(&[("length", length)], ("change", 0.1)));
        let each = each
            .into_iter()
            .map(|column| FitStart::new(vec![column], &["change", "length"]));
        each.collect()
    },
    build: |values, _| {
        let (change, length) = (values.get("change"), values.get("length"));
        braking(Acts::Slide, move |slide| {
            1.0 + change * (-slide.position.distance(slide.from) / length).exp()
        })
    },
    statement: |values| {
        format!(
            "friction is {} where a slide begins, and as elsewhere after some {:.0} mm, wherever objects are struck: an object that sticks while it \
             lies, is lifted by the tip, or slides on a film at first does so; look at its base, at the height at which the tip strikes, and at how long \
             it lies before",
            wording::higher(values.get("change")),
            2e3 * values.get("length")
        )
    },
};

#[cfg(test)]
mod tests {
    use crate::effects::tests::Bench;

    #[test]
    fn it_takes_from_every_slide_the_same_energy() {
        // The first strike's stop, and how much shorter the way is by a friction that is twice as high at first.
        let (change, length) = (1.0, 0.02);
        let plain = Bench::plain();
        let sticky = Bench::with(
            "friction_from_start",
            &[("change", change), ("length", length)],
        );
        for (speed, angle) in [(0.7, 0.0), (0.9, 0.3)] {
            let shorter = plain
                .strike(speed, angle)
                .stop
                .distance(sticky.strike(speed, angle).stop);
            // ∫ change·e^(−s/length) ds in units of friction's own way, less what lies within the impact.
            let expected = change * length;
            assert!(
                (0.7 * expected..1.01 * expected).contains(&shorter),
                "{shorter}"
            );
        }
    }
}
