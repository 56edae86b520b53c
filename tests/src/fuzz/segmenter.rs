//! The segmenter: messages in any order, with any stamp and value, as a log holds them.

use std::io::BufWriter;
use std::sync::Mutex;

use anyhow::anyhow;
use ingest::{Ingest, LogOutcome, ingest_log};
use logs::write::{RecordingWriter, Samples, Stamped, StateSample};
use rig::Sim;
use values::{Command, Point, Rig, Shape};

use super::Reads;

/// Bytes of a message: its topic, stamp, and two values.
const MESSAGE: usize = 25;
/// Every so many commands of the rig are enough to see a plateau.
const THINNED: usize = 5;

/// Strikes of the embedded rig, one with the arm's state.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let rig = Rig::demo(Shape::Cylinder);
    let strike = |log_state: bool, strikes: u32| {
        let sim = Sim::default_for(&rig, 1).expect("a rig");
        let mut sim = if log_state { sim.logging_state() } else { sim };
        let mut messages = Vec::new();
        for strike in 0..strikes {
            let command = Command::new(0.6 + 0.1 * f64::from(strike), 0.1);
            let samples = sim.strike(Point::new(0.3, 0.0), command).samples;
            messages.extend(in_order(&samples));
        }
        messages
    };
    vec![strike(false, 1), strike(true, 1), strike(false, 3)]
}

/// The messages of a strike as bytes, in the order of their stamps.
fn in_order(samples: &Samples) -> Vec<u8> {
    let centroids = samples.centroids.iter().map(|at| (0, *at));
    let commands = samples.commands.iter().step_by(THINNED).map(|at| (1, *at));
    let states = samples.states.iter().step_by(THINNED).map(|state| {
        let [x, y] = state.velocity;
        let stamp = state.stamp;
        (2, Stamped { stamp, x, y })
    });
    let mut all: Vec<(u8, Stamped)> = centroids.chain(commands).chain(states).collect();
    all.sort_by_key(|(_, at)| at.stamp);
    all.iter()
        .flat_map(|(topic, at)| {
            let values = [
                at.stamp.to_le_bytes(),
                at.x.to_le_bytes(),
                at.y.to_le_bytes(),
            ];
            std::iter::once(*topic).chain(values.into_iter().flatten())
        })
        .collect()
}

/// One message alone, so that messages are written in the order given.
fn message(bytes: &[u8]) -> Option<Samples> {
    let number = |at: usize| <[u8; 8]>::try_from(bytes.get(at..at + 8)?).ok();
    let at = Stamped::at(
        u64::from_le_bytes(number(1)?),
        Point::new(
            f64::from_le_bytes(number(9)?),
            f64::from_le_bytes(number(17)?),
        ),
    );
    let mut samples = Samples::default();
    match bytes.first()? % 3 {
        0 => samples.centroids.push(at),
        1 => samples.commands.push(at),
        _ => samples.states.push(StateSample {
            stamp: at.stamp,
            position: [0.2, 0.0],
            velocity: [at.x, at.y],
        }),
    }
    Some(samples)
}

/// Writes the messages into a log and ingests it: every strike seen is kept or rejected, and what is kept is measured.
pub(super) fn reader() -> Reads {
    let folder = tempfile::tempdir().expect("a folder");
    let path = Mutex::new(folder.path().join("session.mcap"));
    let rig = Rig::demo(Shape::Cylinder);
    Box::new(move |input| {
        let _kept = &folder;
        let path = path.lock().map_err(|error| anyhow!("{error}"))?;
        let file = std::fs::File::create(&*path)?;
        let mut writer = RecordingWriter::new(BufWriter::new(file), &rig.topics)?;
        for bytes in input.chunks(MESSAGE) {
            let Some(samples) = message(bytes) else { break };
            writer.write(&samples)?;
        }
        writer.finish()?;
        let outcome = ingest_log(&path, &rig, &Ingest::default())?;
        check(&outcome);
        let reasons: Vec<&str> = outcome.rejects.iter().map(|it| it.reason.name()).collect();
        match &reasons[..] {
            [] => Ok(()),
            reasons => Err(anyhow!(reasons.join(" "))),
        }
    })
}

fn check(outcome: &LogOutcome) {
    let kept = outcome.strikes.iter().map(|strike| strike.index);
    let mut seen: Vec<u32> = kept
        .chain(outcome.rejects.iter().map(|reject| reject.index))
        .collect();
    seen.sort_unstable();
    // Ways back are counted in a note, and given nowhere.
    let mut notes = outcome.notes.iter();
    let back = notes.find(|note| note.contains("ways back"));
    let back = back.and_then(|note| note.split(' ').next()?.parse::<usize>().ok());
    let all = seen.len() + back.unwrap_or(0);
    assert!(
        seen.windows(2).all(|pair| pair[0] < pair[1])
            && seen.last().is_none_or(|last| (*last as usize) < all),
        "a strike is lost or given twice: {seen:?} of {all}"
    );
    for strike in &outcome.strikes {
        let track = &strike.track;
        let numbers = [
            strike.t_start,
            strike.command.speed,
            strike.command.angle,
            strike.initial.x,
            strike.initial.y,
            strike.stop.x,
            strike.stop.y,
        ];
        let all = numbers
            .iter()
            .chain(&track.t)
            .chain(&track.x)
            .chain(&track.y);
        assert!(all.into_iter().all(|value| value.is_finite()), "{strike:?}");
        assert!(track.t.is_sorted_by(|a, b| a < b), "{:?}", track.t);
        assert!(strike.command.speed > 0.0, "{:?}", strike.command);
    }
}
