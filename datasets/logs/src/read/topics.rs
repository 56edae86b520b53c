//! The messages of the topics that are wanted, decoded.

use std::collections::{BTreeMap, HashMap};

use super::event::TopicRequest;
use super::event::{Damage, Event, Extent, Sample, Summary, TopicCount};
use super::pace::Pace;
use super::raw::{RawMessage, RawSummary, Standing, Take, Verdict, unpacked};
use crate::decode::DecodeError;
use crate::{Decoder, LogError};

/// A packed message of numbers unpacks to no more than this, in bytes.
const LARGEST_MESSAGE: usize = 1 << 20;

/// Counts and reasons for one wanted topic.
#[derive(Clone, Default)]
struct MessageCounts {
    decoded: u64,
    undecodable: u64,
    first_reason: String,
    unstamped: bool,
    unchecked: bool,
    pace: Pace,
}

pub(super) struct Topics<'a> {
    wanted: &'a [TopicRequest<'a>],
    /// By their numbers, channels of wanted topics: the topic's index, and the decoder; none where the topic can do without.
    decoders: HashMap<u16, Option<(usize, Decoder)>>,
    counts: Vec<MessageCounts>,
    sink: &'a mut dyn FnMut(Event<'_>),
}

impl Take for Topics<'_> {
    type Error = LogError;

    fn message(
        &mut self,
        message: RawMessage<'_>,
        standing: Standing,
    ) -> Result<Verdict, LogError> {
        let channel = message.channel;
        if !self.decoders.contains_key(&channel.id) {
            let wanted = self
                .wanted
                .iter()
                .position(|wanted| wanted.topic.name == channel.topic);
            if wanted.is_some() && standing.lacks_schema {
                return Ok(Err(format!(
                    "the schema of topic {} is not there",
                    channel.topic
                )));
            }
            let decoder = match wanted {
                Some(index) => self.compile(index, message)?,
                None => None,
            };
            self.decoders.insert(channel.id, decoder);
        }
        let Some(Some((index, decoder))) = self.decoders.get(&channel.id) else {
            return Ok(Ok(()));
        };
        let counts = &mut self.counts[*index];
        let data = unpacked(&message, LARGEST_MESSAGE).map_err(DecodeError::Malformed);
        let decoded = data.and_then(|data| decoder.decode_with(&data));
        let sample = decoded.and_then(|(fields, more, _)| {
            // Known only now where there is no schema.
            counts.unstamped |= fields.stamp.is_none();
            let log_time = i64::try_from(message.log_time).map_err(|_| DecodeError::Stamp);
            if let (Some(stamp), Ok(log_time)) = (fields.stamp, &log_time) {
                counts.pace.take(stamp, *log_time);
            }
            let sample = Sample {
                stamp: fields.stamp.map_or(log_time, Ok)?,
                x: fields.x,
                y: fields.y,
            };
            Ok((sample, more))
        });
        match sample {
            Ok((sample, more)) => {
                counts.decoded += 1;
                counts.unchecked |= !standing.is_checked;
                (self.sink)(if self.wanted[*index].more.is_empty() {
                    Event::Sample(*index, sample)
                } else {
                    Event::Extended(*index, sample, more)
                });
            }
            Err(error) => {
                if counts.undecodable == 0 {
                    counts.first_reason = error.to_string();
                }
                counts.undecodable += 1;
            }
        }
        Ok(Ok(()))
    }

    fn lost(&mut self, damage: &Damage) {
        (self.sink)(Event::Lost(damage));
    }

    fn any_unchecked(&self) -> bool {
        self.counts.iter().any(|counts| counts.unchecked)
    }
}

impl<'a> Topics<'a> {
    pub(super) fn new(wanted: &'a [TopicRequest<'a>], sink: &'a mut dyn FnMut(Event<'_>)) -> Self {
        Self {
            wanted,
            decoders: HashMap::new(),
            counts: vec![MessageCounts::default(); wanted.len()],
            sink,
        }
    }

    /// The decoder of a wanted topic's channel, as its first message comes.
    fn compile(
        &mut self,
        index: usize,
        message: RawMessage<'_>,
    ) -> Result<Option<(usize, Decoder)>, LogError> {
        let TopicRequest {
            topic,
            more,
            required,
        } = self.wanted[index];
        let channel = message.channel;
        let compiled =
            Decoder::compile_with(&channel.encoding, channel.schema(), topic, more, None);
        let counts = &mut self.counts[index];
        match compiled {
            // A log is not refused for a topic that it need not have.
            Err(error) if !required => {
                counts.undecodable += 1;
                counts.first_reason = error.to_string();
                Ok(None)
            }
            compiled => {
                let decoder = compiled?;
                counts.unstamped |= !decoder.stamped();
                Ok(Some((index, decoder)))
            }
        }
    }

    /// What was in the file; an error where a required topic is not, unless it may have been in what is damaged or cut off.
    pub(super) fn summary(self, log: &str, seen: RawSummary) -> Result<Summary, LogError> {
        let mut topics = BTreeMap::new();
        for seen in &seen.channels {
            let channel = &seen.channel;
            let count = topics
                .entry((channel.topic.clone(), channel.schema.clone()))
                .or_insert(0);
            *count += seen.messages;
        }
        let topics: Vec<_> = topics
            .into_iter()
            .map(|((name, schema), messages)| TopicCount {
                name,
                schema,
                messages,
            })
            .collect();
        let summary = Summary {
            sha256: seen.sha256,
            messages: topics.iter().map(|topic| topic.messages).sum(),
            undecodable: self
                .counts
                .iter()
                .map(|counts| (counts.undecodable, counts.first_reason.clone()))
                .collect(),
            unstamped: self.counts.iter().map(|counts| counts.unstamped).collect(),
            paces: self
                .counts
                .iter()
                .map(|counts| counts.pace.measured())
                .collect(),
            topics,
            damage: seen.damage,
        };
        for (wanted, counts) in self.wanted.iter().zip(&self.counts) {
            if wanted.required && counts.decoded == 0 && counts.undecodable > 0 {
                return Err(LogError::Undecodable {
                    log: log.into(),
                    topic: wanted.topic.name.clone(),
                    messages: counts.undecodable,
                    why: counts.first_reason.clone(),
                });
            }
            let there = summary
                .topics
                .iter()
                .any(|topic| topic.name == wanted.topic.name);
            let is_whole = |damage: &Damage| damage.extent == Extent::Index;
            if wanted.required && !there && summary.damage.iter().all(is_whole) {
                let images = ["Image", "CompressedImage"];
                let kind =
                    |topic: &TopicCount| topic.schema.rsplit(['/', '.']).next().map(str::to_string);
                return Err(LogError::MissingTopic {
                    log: log.into(),
                    topic: wanted.topic.name.clone(),
                    found: summary.topics.iter().map(describe).collect(),
                    images: summary
                        .topics
                        .iter()
                        .filter_map(kind)
                        .any(|kind| images.contains(&kind.as_str())),
                });
            }
        }
        Ok(summary)
    }
}

fn describe(topic: &TopicCount) -> String {
    if topic.schema.is_empty() {
        topic.name.clone()
    } else {
        format!("{} ({})", topic.name, topic.schema)
    }
}
