//! What a server has sent so far: its channels, the object's recent places, and the messages for a log.

use std::time::Instant;

use logs::write::Received;
use values::Topics;

use super::channels::{Channels, Sighting};
use super::error::LiveError;
use super::protocol::{self, Control};
use super::recording::{Places, Recording};
use super::rest::{FRESH, Place, Resting};
use super::still::Sentry;
use crate::epoch::Epoch;

/// Greatest difference of a stamp from this computer's clock, in s: a camera's latency, not another clock.
pub(super) const CLOCK: f64 = 0.5;

/// What is known of the topics.
#[derive(Debug)]
pub(super) struct Seen {
    pub(super) channels: Channels,
    pub(super) places: Places,
    pub(super) recording: Recording,
    /// Why nothing comes any more.
    pub(super) fault: Option<LiveError>,
    /// What was wrong with the last message that could not be read.
    pub(super) unread: Option<String>,
    /// By how much (s) the last stamp was behind this computer's clock.
    pub(super) behind: Option<f64>,
    /// The frame of the first place.
    frame: Option<String>,
    /// The lowest height (m) at which the object was seen at rest.
    pub(super) lowest: Option<f64>,
    /// The watch on each message while the tip runs up to the object.
    pub(super) sentry: Option<Sentry>,
    /// The latest stamp, in ns.
    stamp: Option<i64>,
    /// The object's last yaw by its pose, in rad, and when that came.
    turned: Option<(Instant, f64)>,
}

impl Seen {
    pub(super) fn new(topics: &Topics) -> Self {
        Self {
            channels: Channels::new(topics),
            places: Places::default(),
            recording: Recording::default(),
            fault: None,
            unread: None,
            behind: None,
            frame: None,
            lowest: None,
            sentry: None,
            stamp: None,
            turned: None,
        }
    }

    /// Ends it: nothing that comes counts any more; the first reason stays.
    pub(super) fn ends(&mut self, why: LiveError) {
        if let Some(sentry) = &mut self.sentry {
            sentry.is_blind(Instant::now(), &format!("failed to {why}"));
        }
        self.fault.get_or_insert(why);
    }

    /// The error that the object does not rest, and what was wrong with the last message.
    pub(super) fn not_at_rest(&self, why: String) -> LiveError {
        LiveError::NotAtRest(match &self.unread {
            Some(unread) => format!("{why}; {unread}"),
            None => why,
        })
    }

    /// Takes a control message; gives what the server is to be asked. Errors where it is against the protocol.
    pub(super) fn control(&mut self, text: &str) -> Result<Vec<String>, String> {
        let mut answers = Vec::new();
        match protocol::control(text)? {
            Control::Advertise(channels) => {
                for channel in channels {
                    let id = channel.id;
                    if let Some(subscription) = self.channels.advertise(channel)? {
                        answers.push(protocol::subscribe(subscription, id));
                    }
                }
            }
            Control::Unadvertise(ids) => self.channels.unadvertise(&ids),
            // It need not be about a topic that is listened to: it is reported where nothing else comes.
            Control::Error(why) => self.unread = Some(format!("the server reports: {why}")),
            Control::Other => {}
        }
        Ok(answers)
    }

    /// Takes a binary frame that came at a time, in ns since 1970 in the log. Errors where it is against the protocol.
    pub(super) fn data(&mut self, frame: &[u8], at: Instant, log_time: u64) -> Result<(), String> {
        let Some((subscription, message)) = protocol::message(frame)? else {
            return Ok(());
        };
        // A channel that has just gone may have sent a last message.
        let Some(listened) = self.channels.of(subscription) else {
            return Ok(());
        };
        let mut frames = None;
        match listened.read(message) {
            // A tracker that has lost the object may tell its last places again and again.
            Ok(Some(sighting))
                if self.channels.object() == Some(listened.role)
                    && sighting.stamp.is_some()
                    && sighting.stamp <= self.stamp =>
            {
                self.unread = Some("its stamps stand still or run backwards".into());
            }
            Ok(Some(sighting)) if self.channels.object() == Some(listened.role) => {
                self.unread = None;
                self.behind = sighting
                    .stamp
                    .map(|stamp| (i128::from(log_time) - i128::from(stamp)) as f64 * 1e-9);
                // One stamp that is far ahead does not make all after it old.
                if self.behind.is_none_or(|behind| behind.abs() <= CLOCK) {
                    self.stamp = sighting.stamp;
                }
                let (point, z) = (sighting.point, sighting.z);
                // A centroid says nothing of it.
                let fresh = |(came, _): &(Instant, f64)| at.duration_since(*came) <= FRESH;
                let of_pose = self.turned.filter(fresh).map(|(_, yaw)| yaw);
                let yaw = sighting.yaw.or(of_pose);
                if let Some(sentry) = &mut self.sentry {
                    sentry.sees(at, &Resting { point, yaw, z });
                }
                self.places.push(Place { at, point, yaw, z });
                let first = self.frame.get_or_insert_with(|| sighting.frame.clone());
                if *first != sighting.frame {
                    frames = Some(LiveError::Frames(first.clone(), sighting.frame));
                }
            }
            Ok(Some(Sighting { yaw: Some(yaw), .. })) => self.turned = Some((at, yaw)),
            Ok(_) => {}
            Err(why) => self.unread = Some(why),
        }
        self.recording.push(
            at,
            Received {
                channel: listened.raw.clone(),
                log_time,
                data: message.to_vec(),
            },
        );
        if let Some(frames) = frames {
            self.ends(frames);
        }
        Ok(())
    }
}

/// A message of a server.
#[derive(Clone, Copy, Debug)]
pub enum ServerMessage<'a> {
    /// A control message, JSON.
    Control(&'a str),
    /// A binary frame.
    Data(&'a [u8]),
}

/// How many of a server's messages are kept for a log, read without a connection. Errors with what is against the protocol, or with
/// what was wrong with the last message of a topic.
pub fn read_messages(topics: &Topics, messages: &[ServerMessage<'_>]) -> Result<usize, String> {
    let mut seen = Seen::new(topics);
    let now = Instant::now();
    for message in messages {
        match message {
            ServerMessage::Control(text) => drop(seen.control(text)?),
            ServerMessage::Data(frame) => seen.data(frame, now, 0)?,
        }
    }
    match seen.unread {
        Some(why) => Err(why),
        None => Ok(seen.recording.take(Epoch::now()).0.len()),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_centroid_has_the_yaw_of_the_pose_beside_it_while_that_comes() {
        let mut seen = Seen::new(&Topics::default());
        let asked = seen.control(
            r#"{"op":"advertise","channels":[{"id":1,"topic":"/object/centroid","encoding":"json"},
            {"id":2,"topic":"/object/pose","encoding":"json"}]}"#,
        );
        assert_eq!(asked.expect("sound").len(), 2);
        let begun = Instant::now();
        let mut came = |subscription: u32, ms: u64, place: &str| {
            let header =
                format!(r#""header":{{"stamp":{{"sec":1,"nanosec":{ms}}},"frame_id":"table"}}"#);
            let mut frame = vec![1];
            frame.extend(subscription.to_le_bytes());
            frame.extend([0; 8]);
            frame.extend(format!("{{{header},{place}}}").into_bytes());
            let at = begun + Duration::from_millis(ms);
            seen.data(&frame, at, 0).expect("sound");
        };
        let centroid = r#""point":{"x":0.3,"y":0.0,"z":0.0}"#;
        let (sin, cos) = 0.1f64.sin_cos();
        let pose = format!(
            r#""pose":{{"position":{{"x":0.3,"y":0.0,"z":0.0}},"orientation":{{"x":0,"y":0,"z":{sin},"w":{cos}}}}}"#
        );
        came(1, 0, centroid);
        came(2, 10, &pose);
        came(1, 20, centroid);
        came(1, 400, centroid);
        let yaws: Vec<bool> = seen
            .places
            .since(begun)
            .map(|place| place.yaw.is_some_and(|yaw| (yaw - 0.2).abs() < 1e-9))
            .collect();
        assert_eq!(yaws, [false, true, false], "{:?}", seen.unread);
    }
}
