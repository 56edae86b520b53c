//! What is read of logs: `strikes.parquet` and `rejects.parquet`, a row a strike; `tracks.parquet` and `slides.parquet`, a row a frame.

use std::borrow::Borrow;
use std::collections::HashMap;
use std::path::Path;

use arrow::array::RecordBatch;
use arrow::datatypes::SchemaRef;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error as NameError;
use values::{
    Command, Conditions, Delivered, End, Point, Reject, RejectReason, Split, Strike, Track, Yaw,
};

use crate::TableError;
use crate::layout::{Table, count, real, text};
use crate::read::{Batch, read, read_whole};
use crate::write::{Cell, write, write_with};

/// The columns of the public interface, `order`, and what else is known of a strike where the arm's state or the object's yaw was logged: null where
/// it was not. Where `end` is not `rest` there is no stop, and no path. `moving` is the velocity that the object had before, null where it rested.
/// `contact` is on the track's clock; `pushed_again` is 1 where the arm reached the object again or went on pushing it, and null where neither its
/// state nor its command tells.
pub(crate) const STRIKES: Table<24> = Table {
    name: "strikes",
    columns: [
        text("strike_id"),
        text("log"),
        count("index"),
        real("t_start", "s"),
        real("x0", "m"),
        real("y0", "m"),
        real("xf", "m").or_null(),
        real("yf", "m").or_null(),
        real("path_x", "m").or_null(),
        real("path_y", "m").or_null(),
        real("speed", "m/s"),
        real("angle", "rad"),
        count("frames"),
        text("split"),
        text("session"),
        real("order", ""),
        real("tip_speed", "m/s").or_null(),
        real("tip_angle", "rad").or_null(),
        real("contact", "s").or_null(),
        count("pushed_again").or_null(),
        real("yaw0", "rad").or_null(),
        text("end"),
        real("moving_x", "m/s").or_null(),
        real("moving_y", "m/s").or_null(),
    ],
};

pub(crate) const TRACKS: Table<5> = Table {
    name: "tracks",
    columns: [
        text("strike_id"),
        real("t", "s"),
        real("x", "m"),
        real("y", "m"),
        real("yaw", "rad").or_null(),
    ],
};

/// Writes both tables of these strikes, in their order.
pub fn write_strikes(dir: &Path, strikes: &[Strike]) -> Result<(), TableError> {
    stream_strikes(dir, strikes.iter().map(Ok::<_, TableError>))
}

/// Writes both tables of strikes that come one by one; where one does not come, neither table is written.
pub fn stream_strikes<S: Borrow<Strike>, E: From<TableError> + From<durable::Error>>(
    dir: &Path,
    mut strikes: impl Iterator<Item = Result<S, E>>,
) -> Result<(), E> {
    write_with(dir, &STRIKES, |rows| {
        write_with(dir, &TRACKS, |frames| {
            strikes.try_for_each(|strike| {
                let strike = strike?;
                let strike = strike.borrow();
                rows.push(&cells(strike))?;
                Ok(track(strike).try_for_each(|frame| frames.push(&frame))?)
            })
        })
    })
}

fn track(strike: &Strike) -> impl Iterator<Item = [Cell<'_>; 5]> {
    let Track { t, x, y, yaw, .. } = &strike.track;
    t.iter()
        .zip(x)
        .zip(y)
        .zip(0..)
        .map(move |(((t, x), y), frame)| {
            let yaw = yaw.as_ref().and_then(|yaw| yaw.track.get(frame));
            [
                Cell::Text(&strike.id),
                Cell::Real(*t),
                Cell::Real(*x),
                Cell::Real(*y),
                Cell::real_or_null(yaw.copied()),
            ]
        })
}

fn cells(strike: &Strike) -> [Cell<'_>; 24] {
    let (stop, path) = (strike.has_stop().then_some(strike.stop), strike.path());
    let path = stop.map(|_| path);
    let arm = strike.delivered;
    let yaw = strike.track.yaw.as_ref();
    [
        Cell::Text(&strike.id),
        Cell::Text(&strike.log),
        Cell::Count(strike.index),
        Cell::Real(strike.t_start),
        Cell::Real(strike.initial.x),
        Cell::Real(strike.initial.y),
        Cell::real_or_null(stop.map(|stop| stop.x)),
        Cell::real_or_null(stop.map(|stop| stop.y)),
        Cell::real_or_null(path.map(|path| path.x)),
        Cell::real_or_null(path.map(|path| path.y)),
        Cell::Real(strike.command.speed),
        Cell::Real(strike.command.angle),
        Cell::Count(u32::try_from(strike.track.len()).unwrap_or(u32::MAX)),
        Cell::Text(strike.split.name()),
        Cell::Text(&strike.conditions.session),
        Cell::Real(strike.conditions.order),
        Cell::real_or_null(arm.map(|arm| arm.tip_speed)),
        Cell::real_or_null(arm.map(|arm| arm.tip_angle)),
        Cell::real_or_null(arm.map(|arm| arm.contact)),
        match arm.is_some() || strike.conditions.is_pushed_on {
            true => Cell::Count(strike.is_pushed_by_arm().into()),
            false => Cell::Null,
        },
        Cell::real_or_null(yaw.map(|yaw| yaw.initial)),
        Cell::Text(strike.track.end.name()),
        Cell::real_or_null(strike.conditions.moving.map(|moving| moving.x)),
        Cell::real_or_null(strike.conditions.moving.map(|moving| moving.y)),
    ]
}

/// `strikes.parquet` as it lies there, checked to be that table.
pub fn strikes_as_arrow(dir: &Path) -> Result<(SchemaRef, Vec<RecordBatch>), TableError> {
    read_whole(dir, &STRIKES)
}

/// `tracks.parquet` as it lies there, checked to be that table.
pub fn tracks_as_arrow(dir: &Path) -> Result<(SchemaRef, Vec<RecordBatch>), TableError> {
    read_whole(dir, &TRACKS)
}

/// Reads both tables and joins them: each strike with its track, in the order written.
pub fn read_strikes(dir: &Path) -> Result<Vec<Strike>, TableError> {
    let mut strikes = Vec::new();
    let mut frames = Vec::new();
    let mut places = HashMap::new();
    for batch in read(dir, &STRIKES)? {
        let batch = batch?;
        for row in batch.rows() {
            let strike = strike(&batch, row)?;
            if places.insert(strike.id.clone(), strikes.len()).is_some() {
                return Err(batch.wrong(row, format!("strike {} stands there twice", strike.id)));
            }
            strikes.push(strike);
            frames.push(batch.count("frames")[row] as usize);
        }
    }
    for batch in read(dir, &TRACKS)? {
        let batch = batch?;
        let (ids, t, x, y) = (
            batch.text("strike_id"),
            batch.real("t"),
            batch.real("x"),
            batch.real("y"),
        );
        for row in batch.rows() {
            let Some(place) = places.get(ids.value(row)) else {
                return Err(batch.wrong(
                    row,
                    format!("strike {} is not in strikes.parquet", ids.value(row)),
                ));
            };
            let track: &mut Track = &mut strikes[*place].track;
            track.t.push(t[row]);
            track.x.push(x[row]);
            track.y.push(y[row]);
            if let (Some(yaw), Some(here)) = (&mut track.yaw, batch.real_or_null("yaw", row)) {
                yaw.track.push(here);
            }
        }
    }
    for strike in strikes.iter_mut().filter(|strike| !strike.has_stop()) {
        if let Some(last) = strike.track.len().checked_sub(1) {
            strike.stop = strike.track.point(last);
        }
    }
    match strikes
        .iter()
        .zip(&frames)
        .position(|(strike, frames)| strike.track.len() != *frames)
    {
        None => Ok(strikes),
        Some(row) => Err(TableError::Row {
            path: STRIKES.path(dir),
            row,
            why: format!(
                "strike {} has {} frames in tracks.parquet and should have {}",
                strikes[row].id,
                strikes[row].track.len(),
                frames[row]
            ),
        }),
    }
}

/// One strike, its track still empty.
fn strike(batch: &Batch, row: usize) -> Result<Strike, TableError> {
    let real = |name| batch.real(name)[row];
    let text = |name| batch.text(name).value(row).to_string();
    let arm = delivered(batch, row);
    let pushed = batch.count_or_null("pushed_again", row);
    Ok(Strike {
        id: text("strike_id"),
        log: text("log"),
        index: batch.count("index")[row],
        t_start: real("t_start"),
        initial: Point::new(real("x0"), real("y0")),
        stop: stop(batch, row)?,
        command: Command::new(real("speed"), real("angle")),
        track: Track {
            yaw: batch.real_or_null("yaw0", row).map(|initial| Yaw {
                initial,
                track: Vec::new(),
            }),
            end: end(batch, row)?,
            ..Track::default()
        },
        split: split(batch, row)?,
        conditions: Conditions {
            session: text("session"),
            order: real("order"),
            yaw: batch.real_or_null("yaw0", row),
            moving: {
                let velocity = |name| batch.real_or_null(name, row);
                velocity("moving_x")
                    .zip(velocity("moving_y"))
                    .map(|(x, y)| Point::new(x, y))
            },
            is_unstruck: false,
            is_pushed_on: arm.is_none() && pushed == Some(1),
        },
        delivered: arm,
    })
}

/// Where the object came to rest; where it did not, what the track's last frame takes the place of.
fn stop(batch: &Batch, row: usize) -> Result<Point, TableError> {
    let place = |name| batch.real_or_null(name, row);
    match (place("xf").zip(place("yf")), end(batch, row)?) {
        (Some((x, y)), _) => Ok(Point::new(x, y)),
        (None, End::Rest) => Err(batch.wrong(row, "a strike that ends at rest has no stop".into())),
        (None, _) => Ok(Point::default()),
    }
}

fn end(batch: &Batch, row: usize) -> Result<End, TableError> {
    let name = batch.text("end").value(row);
    End::from_name(name).ok_or_else(|| batch.wrong(row, format!("there is no end `{name}`")))
}

fn delivered(batch: &Batch, row: usize) -> Option<Delivered> {
    let real = |name| batch.real_or_null(name, row);
    Some(Delivered {
        tip_speed: real("tip_speed")?,
        tip_angle: real("tip_angle")?,
        contact: real("contact")?,
        pushed_again: batch.count_or_null("pushed_again", row)? != 0,
    })
}

pub(crate) fn split(batch: &Batch, row: usize) -> Result<Split, TableError> {
    let name = batch.text("split").value(row);
    Split::from_name(name).ok_or_else(|| batch.wrong(row, format!("there is no split `{name}`")))
}

/// `t_start` is the stamp of a slide's first frame, `t` the time since. `end` is a track's, as in `strikes.parquet`.
pub(crate) const SLIDES: Table<7> = Table {
    name: "slides",
    columns: [
        text("slide_id"),
        text("log"),
        real("t_start", "s"),
        text("end"),
        real("t", "s"),
        real("x", "m"),
        real("y", "m"),
    ],
};

/// Writes the table of these slides, in their order.
pub fn write_slides(dir: &Path, slides: &[Strike]) -> Result<(), TableError> {
    let rows = slides.iter().flat_map(|slide| {
        (0..slide.track.len()).map(|frame| {
            let at = slide.track.point(frame);
            [
                Cell::Text(&slide.id),
                Cell::Text(&slide.log),
                Cell::Real(slide.t_start),
                Cell::Text(slide.track.end.name()),
                Cell::Real(slide.track.t[frame]),
                Cell::Real(at.x),
                Cell::Real(at.y),
            ]
        })
    });
    write(dir, &SLIDES, rows)
}

pub(crate) const REJECTS: Table<5> = Table {
    name: "rejects",
    columns: [
        text("log"),
        count("index"),
        real("t_start", "s"),
        text("reason"),
        text("detail"),
    ],
};

/// Writes the table of these rejects, in their order.
pub fn write_rejects(dir: &Path, rejects: &[Reject]) -> Result<(), TableError> {
    let rows = rejects.iter().map(|reject| {
        [
            Cell::Text(&reject.log),
            Cell::Count(reject.index),
            Cell::Real(reject.t_start),
            Cell::Text(reject.reason.name()),
            Cell::Text(&reject.detail),
        ]
    });
    write(dir, &REJECTS, rows)
}

/// Reads the table, in the order written.
pub fn read_rejects(dir: &Path) -> Result<Vec<Reject>, TableError> {
    let mut rejects = Vec::new();
    for batch in read(dir, &REJECTS)? {
        let batch = batch?;
        for row in batch.rows() {
            let reason = batch.text("reason").value(row).into_deserializer();
            let reason = RejectReason::deserialize(reason)
                .map_err(|error: NameError| batch.wrong(row, error.to_string()))?;
            rejects.push(Reject {
                log: batch.text("log").value(row).to_string(),
                index: batch.count("index")[row],
                t_start: batch.real("t_start")[row],
                reason,
                detail: batch.text("detail").value(row).to_string(),
            });
        }
    }
    Ok(rejects)
}
