//! `residuals.parquet`: a row for each strike that the residual model learns from or is judged by.

use std::path::Path;

use values::{Point, Residual};

use crate::TableError;
use crate::layout::{Table, real, text};
use crate::read::read;
use crate::strikes::split;
use crate::write::{Cell, write};

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
