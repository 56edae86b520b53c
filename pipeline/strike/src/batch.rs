//! Many targets in one process: a line in, a plan or a refusal out, in the same order.

use std::io::{self, BufRead, BufReader, Read, Write};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use values::Point;

use crate::{Plan, Planner, Reason, Refusal};

/// Longer lines than this, in bytes, are no target.
const LONGEST_LINE: usize = 1 << 16;

/// What came of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatchCounts {
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
    /// How a box is seen turned from the table's axes, in rad.
    #[serde(default)]
    yaw: f64,
}

/// A plan, or why there is none.
#[derive(Serialize)]
#[serde(untagged)]
enum Answer {
    Plan(Box<Plan>),
    Refusal(Refusal),
}

/// Plans every line of `input`, `{"from": [x, y], "to": [x, y]}` in m, and writes a line for each to `output` in the same
/// order. Lines that have arrived are planned together, on all cores, and answered before more are waited for, so that a
/// program may ask line by line. Empty lines are passed over. Errors only where reading or writing fails: a line that is
/// no target is refused by its number.
pub fn run(planner: &Planner, input: impl Read, mut output: impl Write) -> io::Result<BatchCounts> {
    let mut input = BufReader::with_capacity(LONGEST_LINE, input);
    let mut counts = BatchCounts::default();
    let mut before = 0;
    loop {
        let lines = arrived(&mut input)?;
        if lines.is_empty() {
            return Ok(counts);
        }
        let answers: Vec<_> = lines
            .par_iter()
            .enumerate()
            .filter_map(|(index, line)| answer(planner, line, before + index + 1))
            .collect();
        before += lines.len();
        for answer in answers {
            match answer {
                Answer::Plan(_) => counts.planned += 1,
                Answer::Refusal(_) => counts.refused += 1,
            }
            serde_json::to_writer(&mut output, &answer)?;
            output.write_all(b"\n")?;
        }
        output.flush()?;
    }
}

/// Waits for a line, and takes all whole lines that came with it; none at the end.
fn arrived(input: &mut BufReader<impl Read>) -> io::Result<Vec<Vec<u8>>> {
    let mut lines = Vec::new();
    loop {
        let mut line = Vec::new();
        // One byte more than a line may have shows one that is too long.
        let most = LONGEST_LINE as u64 + 1;
        if input.by_ref().take(most).read_until(b'\n', &mut line)? == 0 {
            return Ok(lines);
        }
        if line.len() as u64 == most && line.last() != Some(&b'\n') {
            input.skip_until(b'\n')?;
        }
        lines.push(line);
        if !input.buffer().contains(&b'\n') {
            return Ok(lines);
        }
    }
}

fn answer(planner: &Planner, line: &[u8], number: usize) -> Option<Answer> {
    if line.trim_ascii().is_empty() {
        return None;
    }
    let target = if line.len() > LONGEST_LINE {
        Err(format!("longer than {LONGEST_LINE} bytes"))
    } else {
        serde_json::from_slice::<Target>(line).map_err(|error| error.to_string())
    };
    Some(match target {
        Err(why) => Answer::Refusal(malformed(number, &why)),
        Ok(Target { from, to, yaw }) => match planner.plan_turned(from, to, yaw) {
            Ok(plan) => Answer::Plan(Box::new(plan)),
            Err(refusal) => Answer::Refusal(refusal),
        },
    })
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
