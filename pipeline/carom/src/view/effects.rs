//! The named effects where they act on the table; those that act elsewhere in words.

use values::{Conditions, Point, Rig};
use world::effects::{self, AddedEffect, Family, Slide};
use world::{GRAVITY, World, WorldError};

use super::draw::{Drawing, Ink};

/// Width of the cells in which friction is shown, in m.
const CELL: f64 = 0.02;
/// Distance between arrows, in m, and the length of the longest over it.
const ARROWS: f64 = 0.1;
const LONGEST: f64 = 0.8;
/// Along the longer side of a table, however large, there are no more of them.
const MOST_CELLS: f64 = 200.0;
const MOST_ARROWS: f64 = 40.0;
/// Below this share of the greatest change nothing is drawn.
const LEAST: f64 = 0.05;
/// Where more friction, a push or a shift is, and where less friction is.
const MORE: Ink = Ink([0.94, 0.42, 0.33, 1.0]);
const LESS: Ink = Ink([0.35, 0.62, 0.98, 1.0]);
/// Heights above the table in m, so that nothing flickers.
const HEIGHT: f64 = 0.001;
/// Height of letters in m.
const LETTERS: f64 = 0.03;

/// What a world's effects do, and a sentence of each.
pub fn effects(rig: &Rig, world: &World) -> Result<(Drawing, Vec<String>), WorldError> {
    let (mut drawing, mut sentences) = (Drawing::default(), Vec::new());
    let table = &rig.table;
    let mut below = table.y.low;
    for added in &world.effects {
        draw(&mut drawing, rig, world, added)?;
        let sentence = format!("{}: {added}", added.name);
        below -= 1.5 * LETTERS;
        let at = Point::new(0.5 * (table.x.low + table.x.high), below);
        drawing.text(at, LETTERS, MORE, sentence.clone());
        sentences.push(sentence);
    }
    Ok((drawing, sentences))
}

fn draw(
    drawing: &mut Drawing,
    rig: &Rig,
    world: &World,
    added: &AddedEffect,
) -> Result<(), WorldError> {
    let effect = effects::build(added, rig)?;
    let dry = world.value("friction")? * GRAVITY;
    let conditions = Conditions::default();
    // Effects of a family by place do the same at any speed.
    let slide = |position: Point| Slide {
        position,
        from: position,
        velocity: Point::new(0.5, 0.0),
        spin: 0.0,
        dry,
        conditions: &conditions,
    };
    match effects::effect(&added.name)?.family {
        Family::FrictionByPlace => {
            friction(drawing, rig, |at| effect.friction_factor(&slide(at)) - 1.0);
            edge(drawing, rig, added)?;
        }
        Family::ForceByPlace => arrows(drawing, rig, |at| effect.acceleration(&slide(at))),
        Family::SeenByPlace => arrows(drawing, rig, |at| effect.observe(at) - at),
        _ => {}
    }
    Ok(())
}

/// Cells of the table, the stronger the more friction differs there.
fn friction(drawing: &mut Drawing, rig: &Rig, change: impl Fn(Point) -> f64) {
    let width = spacing(rig, CELL, MOST_CELLS);
    let cells: Vec<(Point, f64)> = grid(rig, width).map(|at| (at, change(at))).collect();
    let greatest = cells
        .iter()
        .fold(0.0, |most, (_, c)| f64::max(most, c.abs()));
    for (at, change) in cells {
        let share = change.abs() / greatest;
        if share > LEAST {
            let ink = if change > 0.0 { MORE } else { LESS };
            let size = [0.95 * width, 0.95 * width, HEIGHT];
            let ink = ink.covering(0.6 * share);
            drawing.slab([at.x, at.y, 0.5 * HEIGHT], size, ink);
            drawing.dot(at, HEIGHT, ink.covering(share));
        }
    }
}

fn edge(drawing: &mut Drawing, rig: &Rig, added: &AddedEffect) -> Result<(), WorldError> {
    let values = effects::values(added)?;
    let ink = |change: f64| if change > 0.0 { MORE } else { LESS };
    match &*added.name {
        "friction_patch" => {
            let edge = effects::patch_edge(&values);
            drawing.line(&edge, 2.0 * HEIGHT, ink(values.get("change")));
        }
        "friction_step" => {
            let direction = values.get("direction");
            let foot = Point::polar(values.get("offset"), direction);
            let along = Point::polar(1.0, direction).rotated(std::f64::consts::FRAC_PI_2);
            if let Some([from, to]) = within(rig, foot, along) {
                drawing.line(&[from, to], 2.0 * HEIGHT, ink(values.get("change")));
            }
        }
        _ => {}
    }
    Ok(())
}

/// The part of a line that lies on the table.
fn within(rig: &Rig, foot: Point, along: Point) -> Option<[Point; 2]> {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (from, step, bounds) in [
        (foot.x, along.x, rig.table.x),
        (foot.y, along.y, rig.table.y),
    ] {
        if step.abs() < 1e-9 {
            if !bounds.contains(from) {
                return None;
            }
            continue;
        }
        let ends = [(bounds.low - from) / step, (bounds.high - from) / step];
        low = low.max(ends[0].min(ends[1]));
        high = high.min(ends[0].max(ends[1]));
    }
    (low < high).then(|| [foot + along * low, foot + along * high])
}

/// Arrows over the table, the longest of a stated length.
fn arrows(drawing: &mut Drawing, rig: &Rig, vector: impl Fn(Point) -> Point) {
    let width = spacing(rig, ARROWS, MOST_ARROWS);
    let all: Vec<(Point, Point)> = grid(rig, width).map(|at| (at, vector(at))).collect();
    let greatest = all
        .iter()
        .fold(0.0, |most, (_, v)| f64::max(most, v.norm()));
    for (at, vector) in all {
        if vector.norm() > LEAST * greatest {
            let to = at + vector * (LONGEST * width / greatest);
            drawing.arrow(at, to, 2.0 * HEIGHT, MORE);
        }
    }
}

/// This distance, or one at which as many cover the longer side of the table.
fn spacing(rig: &Rig, distance: f64, most: f64) -> f64 {
    let (x, y) = (rig.table.x, rig.table.y);
    distance.max((x.high - x.low).max(y.high - y.low) / most)
}

/// Middles of cells of about this width that cover the table.
fn grid(rig: &Rig, width: f64) -> impl Iterator<Item = Point> + use<> {
    let count = |low: f64, high: f64| ((high - low) / width).ceil().max(1.0) as u32;
    let (x, y) = (rig.table.x, rig.table.y);
    let (columns, rows) = (count(x.low, x.high), count(y.low, y.high));
    let middle = move |low: f64, cell: u32| low + (f64::from(cell) + 0.5) * width;
    (0..columns).flat_map(move |column| {
        (0..rows).map(move |row| Point::new(middle(x.low, column), middle(y.low, row)))
    })
}
