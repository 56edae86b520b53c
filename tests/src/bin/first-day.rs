//! What a lab does wrong on its first day, and what `carom check` says: writes tests/FIRST_DAY.md.
//!
//! `first-day --page tests/FIRST_DAY.md [--strikes 60] [--first SEED] [--clean 200] [--fenced 24]`

use std::fmt::Write;
use std::path::PathBuf;

use carom::Outcome;
use clap::Parser;
use rayon::prelude::*;
use serde_json::Value;
use tests::fenced;
use values::Shape;

#[path = "../../../stages/check/tests/support/mistakes.rs"]
mod mistakes;

use mistakes::{Lab, MISTAKES, lab, labs, narrow};

/// Arguments.
#[derive(Debug, Parser)]
struct Args {
    /// Page to write.
    #[arg(long)]
    page: PathBuf,
    /// Strikes of a lab.
    #[arg(long, default_value_t = 60)]
    strikes: usize,
    /// First seed.
    #[arg(long, default_value_t = 71_000)]
    first: u64,
    /// Logs as they should be.
    #[arg(long, default_value_t = 200)]
    clean: usize,
    /// Rigs with a fence and without.
    #[arg(long, default_value_t = 24)]
    fenced: usize,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let labs = labs(args.strikes, args.first);
    let mut page = String::from(
        "# A lab's first day\n\n\
         What a lab does wrong on its first day, and what `carom check` says, which every run begins with. Logs of the embedded rig are read and each message\n\
         is written anew as the mistake would have written it. Made by `make first-day`.\n\n",
    );
    let names: Vec<&str> = labs.iter().map(|(name, _)| *name).collect();
    let _ = writeln!(
        page,
        "Rigs, {} strikes each: {}.\n",
        args.strikes,
        names.join("; ")
    );
    page += "| mistake | refused by the check | published by a run | what is said, of the first rig that is refused |\n|---|---|---|---|\n";
    let (mut refused, mut published, mut all) = (0, 0, 0);
    for mistake in MISTAKES {
        let ended: Vec<Ended> = labs
            .par_iter()
            .map(|(_, lab)| ended(&lab.clone().mistaken(mistake)))
            .collect::<anyhow::Result<_>>()?;
        let checked = ended
            .iter()
            .filter(|e| matches!(e, Ended::Check(_)))
            .count();
        let out = ended
            .iter()
            .filter(|e| matches!(e, Ended::Published))
            .count();
        (refused, published, all) = (refused + checked, published + out, all + ended.len());
        let said = |by_check: bool| {
            ended.iter().find_map(move |ended| match ended {
                Ended::Check(said) if by_check => Some(said.clone()),
                Ended::Gate(said) if !by_check => Some(said.clone()),
                _ => None,
            })
        };
        let said = said(true).or_else(|| said(false)).unwrap_or_default();
        let of = labs.len();
        let _ = writeln!(
            page,
            "| {mistake} | {checked} of {of} | {out} of {of} | {said} |"
        );
        println!("{mistake}: {checked} of {of} refused by the check, {out} published");
        for ((name, _), ended) in labs.iter().zip(&ended) {
            match ended {
                Ended::Check(_) => {}
                Ended::Gate(said) => println!("  {name}: {said}"),
                Ended::Published => println!("  {name}: published"),
            }
        }
    }
    let doubted: Vec<String> = (0..args.clean)
        .into_par_iter()
        .map(|number| {
            let (name, lab) = clean(number, args.first + 1000);
            Ok(refusal(&lab)?.map(|why| format!("{name}: {why}")))
        })
        .collect::<anyhow::Result<Vec<Option<String>>>>()?
        .into_iter()
        .flatten()
        .collect();
    let _ = writeln!(
        page,
        "\n{refused} of {all} logs with a mistake are refused by the check, {published} of {all} are published, and the check refuses {} of {} as they should be: cylinders, boxes and balls; nothing hidden, the demo's mixture, an arm\n\
         that is 3° off, strong tilts, sessions that differ, noise of a real table; strikes at random, one angle, one speed, one place, repeats; 20 to 100 of them.",
        doubted.len(),
        args.clean
    );
    for doubt in &doubted {
        let _ = writeln!(page, "- {doubt}");
    }
    page += &fenced::page(args.fenced, args.first + 2000)?;
    std::fs::write(&args.page, page)?;
    println!("clean: {} of {} refused", doubted.len(), args.clean);
    Ok(())
}

/// Logs as they should be, of their own kind by number.
fn clean(number: usize, first: u64) -> (String, Lab) {
    const HIDES: [&[&str]; 8] = [
        &["none"],
        &["demo"],
        &["striker_angle_bias=0.0524"],
        &["striker_angle_bias=-0.0524", "off_centre_contact"],
        &["table_tilt=0.02,0.015"],
        &[
            "friction_by_session=spread:0.15",
            "striker_angle_by_session=spread:0.03",
        ],
        &[
            "friction_scatter=0.03",
            "camera_correlation=0.6",
            "stray_frames",
        ],
        &["striker_angle_error", "camera_rotation=0.05"],
    ];
    let shape = [Shape::Cylinder, Shape::Box, Shape::Sphere, Shape::Cylinder][number % 4];
    let hide = HIDES[(number / 4) % HIDES.len()];
    let design = (number / 2) % 5;
    let strikes = [20, 40, 60, 100][(number / 3) % 4];
    let name = format!("{shape:?}, {hide:?}, design {design}, {strikes} strikes");
    let made = lab(
        shape,
        strikes,
        first + number as u64,
        hide,
        narrow(design, strikes),
    );
    (name, made)
}

/// What became of logs.
enum Ended {
    /// The check refuses them, and says so.
    Check(String),
    /// A run does not publish what came of them, and says why.
    Gate(String),
    Published,
}

fn ended(lab: &Lab) -> anyhow::Result<Ended> {
    if let Some(said) = refusal(lab)? {
        return Ok(Ended::Check(said));
    }
    let folder = written(lab)?;
    let dir = folder.path().display();
    let line = format!("run {dir}/logs --rig {dir}/rig.toml --out {dir}/run");
    Ok(match tests::carom(&line) {
        Err(error) => Ended::Gate(error.root_cause().to_string()),
        Ok(_) if folder.path().join("run/latest").is_file() => Ended::Published,
        Ok(output) => {
            let said = output
                .text
                .split_once("refused    ")
                .map_or("", |(_, said)| said);
            let said = said.split("report    ").next().unwrap_or_default();
            let words: Vec<&str> = said.split_whitespace().collect();
            Ended::Gate(words.join(" "))
        }
    })
}

fn written(lab: &Lab) -> anyhow::Result<tempfile::TempDir> {
    let folder = tempfile::tempdir()?;
    lab.write(&folder.path().join("logs"));
    std::fs::write(folder.path().join("rig.toml"), lab.rig.to_toml())?;
    Ok(folder)
}

/// What is said where the check refuses the logs.
fn refusal(lab: &Lab) -> anyhow::Result<Option<String>> {
    let folder = written(lab)?;
    let dir = folder.path().display();
    let output = tests::carom(&format!("check {dir}/logs --rig {dir}/rig.toml"))?;
    if output.outcome != Outcome::Refused {
        return Ok(None);
    }
    let findings = output.json["findings"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let gravest = findings
        .iter()
        .find(|finding| finding["severity"] == "meaningless");
    let part = |name: &str| {
        gravest
            .and_then(|finding| finding["words"][name].as_str())
            .map_or_else(|| Value::Null.to_string(), str::to_owned)
    };
    Ok(Some(format!(
        "{}: **{}**; {}",
        part("seen"),
        part("likely"),
        part("mend")
    )))
}
