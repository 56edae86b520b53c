//! Strikes as episodes of a policy's data set: tracks at equal distances in time.

use tables::Episode;
use values::{Point, Strike, median};

/// Decimals of a place in a task's words: centimetres, so that like strikes have one task.
const DECIMALS: usize = 2;
/// Frames a second at the most.
pub const MOST_FPS: u32 = 1000;

/// Frames a second of most tracks, rounded; none where no track has two frames.
pub fn usual_fps(strikes: &[Strike]) -> Option<u32> {
    let rates = strikes.iter().filter_map(|strike| {
        let track = &strike.track;
        let steps = track.len().checked_sub(1).filter(|steps| *steps > 0)?;
        Some(steps as f64 / (track.t[steps] - track.t[0]))
    });
    let rates: Vec<f64> = rates.filter(|rate| rate.is_finite()).collect();
    let usual = median(rates)?;
    Some((usual.round() as u32).clamp(1, MOST_FPS))
}

/// Whether the object's yaw is known in every track.
pub fn all_turn(strikes: &[Strike]) -> bool {
    strikes.iter().all(|strike| strike.track.yaw.is_some())
}

/// A strike as an episode of `fps` frames a second: the first where it was struck, one frame before first motion; the last at rest again, or the track's last
/// whole one. The strike follows the first frame, whose action is the command; the tip's velocity is what the arm delivered where that is known.
pub fn episode(strike: &Strike, fps: u32) -> Episode {
    let track = &strike.track;
    let step = 1.0 / f64::from(fps);
    let last = track.t.last().copied().unwrap_or(0.0);
    let whole = last / step;
    // A track that ends on the grid has no frame beyond it.
    let frames = if strike.has_stop() {
        (whole - 1e-6).ceil()
    } else {
        (whole + 1e-6).floor()
    };
    let mut states = vec![state(strike.initial, first_yaw(strike))];
    states.extend((0..=frames as u32).map(|frame| at(strike, f64::from(frame) * step)));
    let command = strike.command;
    let tip = strike.delivered.map_or(command, |by| by.command());
    // Of an object that moved, command and delivery are relative to it.
    let tip = Point::polar(tip.speed, tip.angle) + strike.conditions.moving.unwrap_or_default();
    let mut actions = vec![[0.0; 4]; states.len()];
    actions[0] = [command.speed, command.angle, tip.x, tip.y].map(|number| number as f32);
    let task = if strike.has_stop() {
        let Point { x, y } = strike.stop;
        format!(
            "strike the object so that it slides and stops at x {x:.DECIMALS$} m, y {y:.DECIMALS$} m"
        )
    } else {
        "strike the object so that it slides".into()
    };
    Episode {
        strike_id: strike.id.clone(),
        split: strike.split,
        task,
        states,
        actions,
    }
}

fn first_yaw(strike: &Strike) -> f64 {
    strike.track.yaw.as_ref().map_or(0.0, |yaw| yaw.initial)
}

fn state(place: Point, yaw: f64) -> [f32; 3] {
    [place.x, place.y, yaw].map(|number| number as f32)
}

/// Where the object is `t` seconds after first motion: linear between frames, at the end beyond them.
fn at(strike: &Strike, t: f64) -> [f32; 3] {
    let track = &strike.track;
    let yaw = |frame: usize| {
        let yaws = track.yaw.as_ref();
        yaws.and_then(|yaw| yaw.track.get(frame).copied())
            .unwrap_or(0.0)
    };
    let after = track.t.partition_point(|&time| time <= t);
    match (after, track.len()) {
        (_, 0) => state(strike.stop, first_yaw(strike)),
        (0, _) => state(track.point(0), yaw(0)),
        (after, frames) if after == frames && strike.has_stop() => {
            state(strike.stop, yaw(frames - 1))
        }
        (after, frames) if after == frames => state(track.point(frames - 1), yaw(frames - 1)),
        _ => {
            let (a, b) = (after - 1, after);
            let share = (t - track.t[a]) / (track.t[b] - track.t[a]);
            let place = track.point(a) * (1.0 - share) + track.point(b) * share;
            state(place, yaw(a) + (yaw(b) - yaw(a)) * share)
        }
    }
}

#[cfg(test)]
mod tests {
    use values::{Command, Track};

    use super::*;

    #[test]
    fn an_episode_begins_at_rest_with_the_command_and_ends_at_the_stop() {
        let mut strike = Strike::bare(
            Command::new(0.5, 0.0),
            Point::new(0.3, 0.0),
            Point::new(0.4, 0.0),
        );
        strike.track = Track {
            t: vec![0.0, 0.03, 0.10],
            x: vec![0.31, 0.34, 0.39],
            y: vec![0.0; 3],
            ..Track::default()
        };
        let episode = episode(&strike, 50);
        let x: Vec<f32> = episode.states.iter().map(|state| state[0]).collect();
        // At rest; at 0, 0.02, 0.04, 0.06, 0.08 s, between frames; and at 0.1 s, at rest.
        let expected = [0.3, 0.31, 0.33, 0.347_143, 0.361_429, 0.375_714, 0.4];
        assert_eq!(x.len(), expected.len());
        for (x, expected) in x.iter().zip(expected) {
            assert!((x - expected).abs() < 1e-6, "{x} {expected}");
        }
        assert_eq!(episode.actions[0], [0.5, 0.0, 0.5, 0.0]);
        assert!(
            episode.actions[1..]
                .iter()
                .all(|action| *action == [0.0; 4])
        );
        assert!(
            episode.task.ends_with("x 0.40 m, y 0.00 m"),
            "{}",
            episode.task
        );
        assert_eq!(usual_fps(std::slice::from_ref(&strike)), Some(20));
        // The tip met an object that came towards it: the command is what the tip did beside it.
        strike.conditions.moving = Some(Point::new(-0.2, 0.1));
        let met = super::episode(&strike, 50).actions[0];
        assert_eq!(met, [0.5, 0.0, 0.3, 0.1]);
    }
}
