//! Files that are written: those that a run leaves in its folder (contract, section 4), and new ones that take no other's place.
//!
//! `world.toml`, `solutions.parquet` and `residuals.parquet` are those of the world that will be used: the one with effects
//! where they are named, and then `world_sysid.toml` is the plain one.

use std::fs;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use diagnose::Diagnosis;
use judge::Solved;
use serde::Serialize;
use tables::SolutionRow;
use values::Strike;
use world::World;

use crate::Error;
use crate::pipeline::Step;
use crate::results::Results;

/// Strikes that would best distinguish the leading candidates, as a plan.
pub const NEXT_STRIKES: &str = "next_strikes.json";

/// Writes what the steps up to and with `last` gave. Every file is whole or absent; the same results give the same bytes.
pub fn write(dir: &Path, results: &Results, last: Step) -> Result<(), Error> {
    tables::stream_strikes(
        dir,
        results
            .read
            .strikes
            .iter()
            .map(|read| read.map_err(Error::from)),
    )?;
    tables::write_rejects(dir, &results.read.rejects).map_err(Error::failed)?;
    tables::write_slides(dir, &results.read.slides).map_err(Error::failed)?;
    let Some(worlds) = &results.worlds else {
        return Ok(());
    };
    let (_, used) = worlds.used();
    write_world(dir, "world.toml", Some(&used.world))?;
    let plain = worlds.effect.as_ref().map(|_| &worlds.sysid.world);
    write_world(dir, "world_sysid.toml", plain)?;
    if last >= Step::Diagnose {
        write_diagnosis(dir, worlds.found().map(|found| &found.diagnosis))?;
    }
    if let Some(solved) = &used.solved {
        let rows = solution_rows(&results.strikes, &solved.paths);
        tables::write_solutions(dir, &rows).map_err(Error::failed)?;
        if last >= Step::Residual {
            tables::write_residuals(dir, &solved.residuals.rows).map_err(Error::failed)?;
        }
    }
    if let Some(evaluation) = &worlds.evaluation {
        write_json(&dir.join("evaluation.json"), evaluation)?;
    }
    Ok(())
}

/// Writes a world; one that an earlier run left where there is none any more is removed.
fn write_world(dir: &Path, name: &str, world: Option<&World>) -> Result<(), Error> {
    let path = dir.join(name);
    match world {
        Some(world) => Ok(durable::write_bytes(&path, world.to_toml().as_bytes())?),
        None => remove(&path),
    }
}

/// Writes `diagnosis.json`, and its next strikes as a plan for `carom demo --plan`; what there is none of is removed.
fn write_diagnosis(dir: &Path, diagnosis: Option<&Diagnosis>) -> Result<(), Error> {
    let path = dir.join("diagnosis.json");
    match diagnosis {
        Some(diagnosis) => write_json(&path, diagnosis)?,
        None => remove(&path)?,
    }
    let path = dir.join(NEXT_STRIKES);
    match diagnosis.map_or(&[][..], |diagnosis| &diagnosis.next_strikes) {
        [] => remove(&path),
        strikes => write_json(&path, strikes),
    }
}

fn remove(path: &Path) -> Result<(), Error> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(durable::Error::new("remove", path, error).into())
        }
        _ => Ok(()),
    }
}

/// Writes a value as JSON that a person can read.
pub fn write_json<T: Serialize + ?Sized>(path: &Path, value: &T) -> Result<(), Error> {
    let mut text = serde_json::to_string_pretty(value).map_err(Error::failed)?;
    text.push('\n');
    Ok(durable::write_bytes(path, text.as_bytes())?)
}

fn solution_rows(strikes: &[Strike], solved: &[(usize, Solved)]) -> Vec<SolutionRow> {
    let rows = solved.iter().map(|(place, path)| (*place, path.solution));
    rows.map(|(place, solution)| SolutionRow {
        strike_id: strikes[place].id.clone(),
        speed_sim: solution.command.speed,
        angle_sim: solution.command.angle,
        miss: solution.miss,
        evaluations: solution.evaluations,
        status: solution.status.name().into(),
    })
    .collect()
}

/// Permissions of an ordinary file, before the user's mask.
pub const ORDINARY: u32 = 0o666;

/// Writes a file that must not be there yet, with these permissions; it is on disk when this returns.
pub fn write_new(path: &Path, mode: u32, bytes: &[u8]) -> Result<(), Error> {
    let created = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(mode)
        .open(path);
    let mut file = created.map_err(|error| {
        let help = match error.kind() {
            ErrorKind::AlreadyExists => "nothing is overwritten, name another file",
            _ => "name a file in a folder that is there and may be written to",
        };
        Error::input(format!("create {}: {error}; {help}", path.display()))
    })?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all());
    written.map_err(|error| Error::failed(format!("write {}: {error}", path.display())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::found_tilt;
    use crate::results::testing::diagnosed;

    #[test]
    fn a_named_effect_is_in_the_world_with_the_plain_one_beside_it() {
        let dir = tempfile::tempdir().expect("folder");
        let world = |name: &str| World::load(&dir.path().join(name)).expect(name);
        let found = found_tilt();
        write(dir.path(), &diagnosed(Some(found.clone())), Step::Diagnose).expect("written");
        assert_eq!(Some(world("world.toml")), found.world);
        assert!(world("world_sysid.toml").effects.is_empty());
        let text = |name: &str| fs::read_to_string(dir.path().join(name)).expect(name);
        assert_eq!(
            serde_json::from_str::<Diagnosis>(&text("diagnosis.json")).expect("own text"),
            found.diagnosis
        );
        // Both are plans that the rig reads.
        for name in ["diagnosis.json", NEXT_STRIKES] {
            let plan = rig::parse_plan(&text(name)).expect("a plan");
            assert_eq!(plan.len(), found.diagnosis.next_strikes.len(), "{name}");
        }

        // What is not found any more does not stay.
        write(dir.path(), &diagnosed(None), Step::Diagnose).expect("written");
        assert!(world("world.toml").effects.is_empty());
        for name in ["world_sysid.toml", "diagnosis.json", NEXT_STRIKES] {
            assert!(!dir.path().join(name).exists(), "{name}");
        }
    }

    #[test]
    fn a_diagnosis_has_the_contracts_keys() {
        let json = serde_json::to_value(found_tilt().diagnosis).expect("plain data");
        for pointer in [
            "/verdict",
            "/where/0/covariate",
            "/where/0/description",
            "/where/0/p_value",
            "/where/0/share",
            "/effects/0/name",
            "/effects/0/parameters/tilt_x/value",
            "/effects/0/parameters/tilt_x/low",
            "/effects/0/parameters/tilt_x/high",
            "/effects/0/parameters/tilt_x/unit",
            "/effects/0/statement",
            "/effects/0/evidence",
            "/effects/0/equivalent",
            "/ranking/0/name",
            "/ranking/0/evidence",
            "/gap/heldout_strikes",
            "/gap/before",
            "/gap/after",
            "/gap/noise_floor",
            "/gap/unit",
            "/gap/measure",
            "/next_strikes/0/x0",
            "/next_strikes/0/y0",
            "/next_strikes/0/speed",
            "/next_strikes/0/angle",
            "/next_strikes/0/why",
        ] {
            assert!(json.pointer(pointer).is_some(), "{pointer}");
        }
        assert_eq!(json["verdict"], "named");
    }
}
