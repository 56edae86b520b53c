//! The files that a run leaves in its folder (contract, section 4).

use std::path::Path;

use serde::Serialize;
use tables::{ResidualRow, SolutionRow};

use crate::Error;
use crate::pipeline::{Results, Step};

/// Writes what the steps up to and with `last` gave. Every file is whole or absent; the same results give the same bytes.
pub fn write(dir: &Path, results: &Results, last: Step) -> Result<(), Error> {
    tables::write_strikes(dir, &results.strikes).map_err(Error::failed)?;
    tables::write_rejects(dir, &results.rejects).map_err(Error::failed)?;
    if let Some(fit) = &results.fit {
        durable::write_bytes(&dir.join("world.toml"), fit.world.to_toml().as_bytes())?;
    }
    if last >= Step::Solve {
        tables::write_solutions(dir, &solution_rows(results)).map_err(Error::failed)?;
    }
    if last >= Step::Residual {
        tables::write_residuals(dir, &residual_rows(results)).map_err(Error::failed)?;
    }
    if let Some(evaluation) = &results.evaluation {
        write_json(&dir.join("evaluation.json"), evaluation)?;
    }
    Ok(())
}

/// Writes a value as JSON that a person can read.
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Error> {
    let mut text = serde_json::to_string_pretty(value).map_err(Error::failed)?;
    text.push('\n');
    Ok(durable::write_bytes(path, text.as_bytes())?)
}

fn solution_rows(results: &Results) -> Vec<SolutionRow> {
    let rows = results.strikes.iter().zip(&results.solutions);
    rows.map(|(strike, solution)| SolutionRow {
        strike_id: strike.id.clone(),
        speed_sim: solution.command.speed,
        angle_sim: solution.command.angle,
        miss: solution.miss,
        evaluations: solution.evaluations,
        status: solution.status.name().into(),
    })
    .collect()
}

fn residual_rows(results: &Results) -> Vec<ResidualRow> {
    let rows = results.residuals.rows.iter();
    rows.map(|row| ResidualRow {
        strike_id: row.strike_id.clone(),
        path: row.path,
        speed_sim: row.speed_sim,
        angle_sim: row.angle_sim,
        d_speed: row.d_speed,
        d_angle: row.d_angle,
        split: row.split,
    })
    .collect()
}
