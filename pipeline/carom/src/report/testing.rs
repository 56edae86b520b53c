//! A diagnosis made by hand, and the page that shows it.

use diagnose::{Diagnosed, StopResidual, Verdict};
use serde_json::json;
use values::{Command, Point, Rig, Shape, Strike};
use world::{AddedEffect, Estimate, World};

use super::input::ReportInput;
use super::page;
use super::provenance::Provenance;
use crate::inputs::Inputs;
use crate::results::Results;
use crate::results::testing::diagnosed;

/// A table tilt, named.
pub fn found_tilt() -> Diagnosed {
    let tilt = json!({ "value": 0.0042, "low": 0.0040, "high": 0.0044, "unit": "rad" });
    let diagnosis = json!({
        "verdict": "named",
        "summary": "The table is not level.",
        "p_value": 1e-12, "p_value_signs": 0.002, "replicates": 299,
        "maps": [{
            "name": "launch", "before": 0.02, "after": 0.01, "share": 0.75,
            "points": [
                { "at": [0.5, 0.1], "change": [0.05, -0.01] },
                { "at": [0.9, -0.1], "change": [-0.10, 0.02] },
            ],
        }],
        "strikes": 80,
        "where": [{ "covariate": "angle", "description": "strikes to the left go too far", "p_value": 1e-9, "share": 0.61 }],
        "effects": [{
            "name": "table_tilt",
            "parameters": { "tilt_x": tilt },
            "statement": "the table slopes down by 4.2 mm per metre",
            "evidence": 57.2, "equivalent": ["a steady draught"], "rivals": [],
        }],
        "ranking": [{ "name": "table_tilt", "evidence": 57.2 }, { "name": "table_bowl", "evidence": -1.0 }],
        "gap": {
            "heldout_strikes": 2, "before": 0.0213, "after": 0.0012,
            "change": 0.0012 / 0.0213 - 1.0, "change_half_95": 0.031,
            "noise_floor": 0.001, "wander": 0.0, "sessions": 0.0, "unit": "m", "measure": "rms stop error",
        },
        "next_strikes": [
            { "x0": 0.27, "y0": 0.05, "speed": 0.9, "angle": 0.2, "why": "distinguishes table_tilt from table_bowl" },
        ],
        "detectable": [{ "name": "table_bowl", "parameter": "curvature", "least": 0.021, "unit": "/s²" }],
        "notes": ["one candidate diverged"],
    });
    let mut world = World::nominal();
    let tilted = Estimate::with_interval(0.0042, 0.0040, 0.0044);
    world.effects.push(AddedEffect {
        name: "table_tilt".into(),
        parameters: [("tilt_x".to_string(), tilted)].into(),
    });
    let residual = |index: usize| StopResidual {
        strike_id: index.to_string(),
        is_heldout: index.is_multiple_of(3),
        before: [0.02, -0.01 * index as f64],
        after: [0.001, -0.001],
    };
    Diagnosed {
        diagnosis: serde_json::from_value(diagnosis).expect("a diagnosis"),
        world: Some(world),
        carried: None,
        residuals: (0..4).map(residual).collect(),
    }
}

/// A strike without a track.
pub fn strike(index: usize) -> Strike {
    Strike {
        id: index.to_string(),
        log: "a.mcap".into(),
        index: index as u32,
        t_start: index as f64,
        ..Strike::bare(
            Command::new(0.5 + 0.1 * index as f64, 0.2),
            Point::new(0.2, 0.0),
            Point::new(0.5 + 0.05 * index as f64, 0.1),
        )
    }
}

fn text(found: Diagnosed, is_used: bool) -> String {
    let mut results = Results {
        strikes: (0..4).map(strike).collect(),
        ..diagnosed(Some(found))
    };
    if let (false, Some(worlds)) = (is_used, &mut results.worlds) {
        worlds.effect = None;
    }
    text_of(&results, &Provenance::default())
}

fn text_of(results: &Results, provenance: &Provenance) -> String {
    let inputs = Inputs {
        named: Vec::new(),
        rig: Rig::demo(Shape::Cylinder),
        logs: Vec::new(),
        seed: 0,
        without_effects: false,
    };
    let shown = ReportInput {
        night: None,
        versions: Vec::new(),
        inputs: &inputs,
        results,
        trial: None,
        provenance,
    };
    page::page(&shown).expect("a page")
}

#[test]
fn the_page_shows_verdict_parameters_gap_pictures_and_next_strikes() {
    let page = text(found_tilt(), true);
    for said in [
        "Where simulation and strikes disagree",
        "</strong> The table is not level.",
        "the table slopes down by 4.2 mm per metre",
        "0.00420",
        "0.00400 … 0.00440",
        "cannot distinguish it from a steady draught",
        "21.3 mm before, 1.2 mm after",
        "99 % of the gap is closed",
        "table_bowl",
        "distinguishes table_tilt from table_bowl",
        "0.021 /s²",
        "one candidate diverged",
        "launch speed beyond the command (up to 10.0 %)",
        "75 %",
        "the arm",
        "How repeats of one command differ",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // The strikes' map; the launch's speed and angle; two of residuals; along and across against five covariates.
    assert_eq!(page.matches("<figure").count(), 1 + 2 + 2 + 2 * 5);
    assert!(page.contains("A gap like this comes by chance"));
    assert!(!page.contains("not added"));
    assert!(text(found_tilt(), false).contains("not added"));
}

#[test]
fn without_a_named_effect_there_is_one_map_and_no_after() {
    let mut found = found_tilt();
    found.world = None;
    found.diagnosis.effects.clear();
    found.diagnosis.next_strikes.clear();
    found.diagnosis.verdict = Verdict::Unexplained;
    let page = text(found, true);
    assert!(page.contains("Unexplained:"));
    assert_eq!(page.matches("<figure").count(), 1 + 2 + 1 + 2 * 5);
    assert!(page.contains("Something that no effect of the library explains"));
    assert!(
        !page.contains("with the effects") && !page.contains("The most informative next strikes")
    );
}

#[test]
fn the_page_of_many_strikes_each_in_a_log_and_a_session_of_its_own_is_bounded() {
    let many = |count: usize| {
        let log = |index: usize| format!("{index:05}.mcap");
        let strikes = (0..count).map(|index| {
            let mut strike = strike(index);
            strike.log = log(index);
            strike.conditions.session = strike.log.clone();
            strike
        });
        let results = Results {
            strikes: strikes.collect(),
            ..diagnosed(Some(found_tilt()))
        };
        let hash = |index| (log(index), "0".repeat(64));
        let provenance = Provenance {
            hashes: (0..count).map(hash).collect(),
            ..Provenance::default()
        };
        text_of(&results, &provenance).len()
    };
    let (some, many) = (many(20_000), many(60_000));
    assert!(many < some + some / 10, "{many} of {some}");
}
