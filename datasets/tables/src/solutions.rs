//! `solutions.parquet`: a row for each path that was solved. `residuals.parquet`: one for each strike that the residual model learns from
//! or is judged by.

use std::path::Path;

use values::{Point, Residual};

use crate::TableError;
use crate::layout::{Table, count, real, text};
use crate::read::read;
use crate::strikes::split;
use crate::write::{Cell, write};

/// The command that makes the simulated object take a strike's path.
#[derive(Clone, Debug, PartialEq)]
pub struct SolutionRow {
    /// Which strike.
    pub strike_id: String,
    /// Speed in m/s.
    pub speed_sim: f64,
    /// Angle in rad, from +x.
    pub angle_sim: f64,
    /// Distance in m by which the simulated stop misses the strike's.
    pub miss: f64,
    /// Simulations that it took.
    pub evaluations: u32,
    /// `solved`, `unreachable` or `diverged`.
    pub status: String,
}

pub(crate) const SOLUTIONS: Table<6> = Table {
    name: "solutions",
    columns: [
        text("strike_id"),
        real("speed_sim", "m/s"),
        real("angle_sim", "rad"),
        real("miss", "m"),
        count("evaluations"),
        text("status"),
    ],
};

/// Writes the table of these solutions, in their order.
pub fn write_solutions(dir: &Path, solutions: &[SolutionRow]) -> Result<(), TableError> {
    let rows = solutions.iter().map(|solution| {
        [
            Cell::Text(&solution.strike_id),
            Cell::Real(solution.speed_sim),
            Cell::Real(solution.angle_sim),
            Cell::Real(solution.miss),
            Cell::Count(solution.evaluations),
            Cell::Text(&solution.status),
        ]
    });
    write(dir, &SOLUTIONS, rows)
}

/// Reads the table, in the order written.
pub fn read_solutions(dir: &Path) -> Result<Vec<SolutionRow>, TableError> {
    let mut solutions = Vec::new();
    for batch in read(dir, &SOLUTIONS)? {
        let batch = batch?;
        solutions.extend(batch.rows().map(|row| SolutionRow {
            strike_id: batch.text("strike_id").value(row).to_string(),
            speed_sim: batch.real("speed_sim")[row],
            angle_sim: batch.real("angle_sim")[row],
            miss: batch.real("miss")[row],
            evaluations: batch.count("evaluations")[row],
            status: batch.text("status").value(row).to_string(),
        }));
    }
    Ok(solutions)
}

pub(crate) const RESIDUALS: Table<8> = Table {
    name: "residuals",
    columns: [
        text("strike_id"),
        real("path_x", "m"),
        real("path_y", "m"),
        real("speed_sim", "m/s"),
        real("angle_sim", "rad"),
        real("d_speed", "m/s"),
        real("d_angle", "rad"),
        text("split"),
    ],
};

/// Writes the table of these residuals, in their order.
pub fn write_residuals(dir: &Path, residuals: &[Residual]) -> Result<(), TableError> {
    let rows = residuals.iter().map(|residual| {
        [
            Cell::Text(&residual.strike_id),
            Cell::Real(residual.path.x),
            Cell::Real(residual.path.y),
            Cell::Real(residual.speed_sim),
            Cell::Real(residual.angle_sim),
            Cell::Real(residual.d_speed),
            Cell::Real(residual.d_angle),
            Cell::Text(residual.split.name()),
        ]
    });
    write(dir, &RESIDUALS, rows)
}

/// Reads the table, in the order written.
pub fn read_residuals(dir: &Path) -> Result<Vec<Residual>, TableError> {
    let mut residuals = Vec::new();
    for batch in read(dir, &RESIDUALS)? {
        let batch = batch?;
        for row in batch.rows() {
            let real = |name| batch.real(name)[row];
            residuals.push(Residual {
                strike_id: batch.text("strike_id").value(row).to_string(),
                path: Point::new(real("path_x"), real("path_y")),
                speed_sim: real("speed_sim"),
                angle_sim: real("angle_sim"),
                d_speed: real("d_speed"),
                d_angle: real("d_angle"),
                split: split(&batch, row)?,
            });
        }
    }
    Ok(residuals)
}
