//! Many targets in one process: a line in, a plan or a refusal out, in the same order.

use std::io::{self, BufRead, Write};

use serde::Deserialize;
use values::Point;

use crate::{Planner, Reason, Refusal};

/// Longer lines than this, in bytes, are no target.
const LONGEST_LINE: u64 = 1 << 16;

/// What came of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Lines that became a plan.
    pub planned: usize,
    /// Lines that became a refusal.
    pub refused: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Target {
    from: Point,
    to: Point,
}

/// Plans every line of `input`, `{"from": [x, y], "to": [x, y]}` in m, and writes a line for each to `output` as soon as
/// it is planned, so that a program may ask line by line. Empty lines are passed over. Errors only where reading or
/// writing fails: a line that is no target is refused by its number.
pub fn run(
    planner: &Planner,
    mut input: impl BufRead,
    mut output: impl Write,
) -> io::Result<Tally> {
    let mut tally = Tally::default();
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        if io::Read::take(&mut input, LONGEST_LINE).read_until(b'\n', &mut line)? == 0 {
            break;
        }
        if line.len() as u64 == LONGEST_LINE && line.last() != Some(&b'\n') {
            input.skip_until(b'\n')?;
            let why = format!("longer than {LONGEST_LINE} bytes");
            tally.refused += 1;
            put(&mut output, &malformed(number, &why))?;
            continue;
        }
        if line.trim_ascii().is_empty() {
            continue;
        }
        let planned = serde_json::from_slice::<Target>(&line)
            .map_err(|error| malformed(number, &error.to_string()))
            .and_then(|Target { from, to }| planner.plan(from, to));
        match planned {
            Ok(plan) => {
                tally.planned += 1;
                put(&mut output, &plan)?;
            }
            Err(refusal) => {
                tally.refused += 1;
                put(&mut output, &refusal)?;
            }
        }
    }
    Ok(tally)
}

fn malformed(number: usize, why: &str) -> Refusal {
    Refusal {
        from: None,
        to: None,
        refused: Reason::Malformed,
        detail: format!(
            r#"line {number}: {why}; write {{"from": [x, y], "to": [x, y]}}, in m, on one line"#
        ),
    }
}

fn put(output: &mut impl Write, answer: &impl serde::Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *output, answer)?;
    output.write_all(b"\n")?;
    output.flush()
}
