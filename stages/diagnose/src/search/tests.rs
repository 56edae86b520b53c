//! What is told of an effect whose form stands at the end of its range.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::{Command, Conditions, Point, Rig, Shape, Split, Strike, Track};
use world::{AddedEffect, Estimate, Simulator, World, effects};

use super::{Limits, refine::refine, search};
use crate::{
    Diagnose, Input, candidates::candidates, evidence, fitted_world::fitted_world, null,
    run::prepare, score::ScoreTest, screen::screen_by,
};

/// Scatter of launches: relative speed, and rad; camera noise in m.
const SCATTER: (f64, f64, f64) = (0.005, 0.003, 0.4e-3);

/// Strikes over a table of two sheets: friction is higher beyond a straight seam.
fn strikes(rig: &Rig, plain: &World) -> Vec<Strike> {
    let mut hidden = plain.clone();
    let parameters = [("direction", 0.0), ("offset", 0.45), ("change", 0.4)];
    hidden.effects.push(AddedEffect {
        name: "friction_step".into(),
        parameters: parameters
            .map(|(name, value)| (name.to_string(), Estimate::fixed(value)))
            .into(),
    });
    let simulator = Simulator::new(rig, &hidden).expect("a world");
    let mut worker = simulator.worker();
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    (0..60_u32)
        .map(|i| {
            let share = f64::from(i) / 60.0;
            let command = Command {
                speed: 0.5 + 0.5 * ((7.0 * share) % 1.0),
                angle: -0.2 + 0.4 * ((11.0 * share) % 1.0),
            };
            // Along so much of the seam that no disc of half a metre has an edge as straight.
            let initial = Point::new(0.25, 1.2 * ((5.0 * share) % 1.0) - 0.6);
            let delivered = Command {
                speed: command.speed * (1.0 + SCATTER.0 * normal()),
                angle: command.angle + SCATTER.1 * normal(),
            };
            let conditions = Conditions::default();
            let simulated = worker
                .strike(initial, delivered, &conditions)
                .expect("rests");
            let mut seen = |point: Point| point + Point::new(normal(), normal()) * SCATTER.2;
            let mut track = Track::default();
            let mut t = 1.0 / rig.camera.rate;
            while t <= simulated.rest_time {
                let at = seen(simulated.at(t));
                track.t.push(t);
                track.x.push(at.x);
                track.y.push(at.y);
                t += 1.0 / rig.camera.rate;
            }
            Strike {
                id: format!("{i:016x}"),
                log: String::new(),
                index: i,
                t_start: 5.0 * f64::from(i),
                initial,
                stop: seen(simulated.stop),
                command,
                track,
                split: Split::Train,
                conditions,
                delivered: None,
            }
        })
        .collect()
}

#[test]
fn a_patch_at_the_limit_of_its_radius_is_not_named_alone_and_its_interval_is_the_range() {
    let rig = Rig::demo(Shape::Cylinder);
    let plain = World::nominal(&rig)
        .with("friction", 0.22)
        .with("restitution", 0.5);
    let stage = Diagnose::default();
    let input = Input {
        strikes: strikes(&rig, &plain),
        rig: rig.clone(),
        world: plain.clone(),
    };
    let (usable, _) = stage.usable(&input).expect("strikes");
    let (prepared, _) = prepare(&rig, &plain, &usable).expect("launches");
    let (prepared, null) = null::fit_null(prepared, &plain).expect("a fit");
    let all = candidates(&rig, &prepared.strikes);
    let replicates = evidence::replicates(stage.seed);
    let test = ScoreTest::new(&prepared, &null, &[], replicates).expect("a test");
    let screened = screen_by(&prepared, &null, &test, &all, replicates).expect("scores");
    let chance = evidence::chance(&screened);

    // As if the library had no effect with a straight edge: the larger the disc, the straighter its edge.
    let patch: Vec<_> = all
        .iter()
        .filter(|candidate| candidate.name == "friction_patch")
        .cloned()
        .collect();
    let of_patch: Vec<_> = screened
        .iter()
        .filter(|screened| screened.name == "friction_patch")
        .cloned()
        .collect();
    let limits = Limits {
        effects: 1,
        replicates,
    };
    let found = search(&prepared, &null, &of_patch, &patch, &chance, &limits).expect("a search");
    let model = &found.fitted.model;
    let at_end: Vec<&str> = model.forms_at_end().map(|(_, name, _)| name).collect();
    assert!(at_end.contains(&"radius"), "{at_end:?}: {:?}", model.values);

    // Told by its whole range, not by the curvature at its end.
    let world = fitted_world(&plain, &found.fitted, found.prepared.noise).expect("a world");
    let radius = &world.effects[0].parameters["radius"];
    let range = effects::effect("friction_patch")
        .expect("an effect")
        .parameter("radius")
        .expect("a radius");
    assert_eq!(
        (radius.low, radius.high),
        (Some(range.low), Some(range.high))
    );

    // Beside the whole library the best of the others stands with it, however much the patch gains.
    let refined = refine(found, &all, &chance, 0).expect("a fit");
    assert!(
        !refined.effects[0].equivalent.is_empty(),
        "{:?}",
        refined.effects[0]
    );
}
