//! A file's schemas and channels, and the messages of those that are wanted.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use mcap::records::{MessageHeader, Record, op};

use super::damage::{Damage, Extent};
use super::event::{Event, Sample};
use super::request::TopicRequest;
use super::summary::{Summary, TopicCount};
use crate::decode::DecodeError;
use crate::{Decoder, LogError, SchemaText};

/// What a record was: read, or wrong in a way that loses no more than itself.
type Outcome = Result<Result<(), String>, LogError>;

struct Schema {
    name: String,
    encoding: String,
    data: Vec<u8>,
}

struct Channel {
    topic: String,
    encoding: String,
    schema: u16,
    messages: u64,
    /// Index among the wanted topics, and the decoder once the first message came.
    wanted: Option<(usize, Option<Decoder>)>,
}

/// Counts and reasons for one wanted topic.
#[derive(Clone, Default)]
struct MessageCounts {
    decoded: u64,
    undecodable: u64,
    first_reason: String,
    unstamped: bool,
    unchecked: bool,
}

pub(super) struct Topics<'a> {
    log: &'a str,
    wanted: &'a [TopicRequest<'a>],
    schemas: HashMap<u16, Arc<Schema>>,
    channels: HashMap<u16, Channel>,
    counts: Vec<MessageCounts>,
    /// Bytes that schemas and channels take, and may take.
    held: usize,
    limit: usize,
}

impl<'a> Topics<'a> {
    pub(super) fn new(log: &'a str, wanted: &'a [TopicRequest<'a>], limit: usize) -> Self {
        let counts = vec![MessageCounts::default(); wanted.len()];
        Self {
            log,
            wanted,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            counts,
            held: 0,
            limit,
        }
    }

    /// Takes one record, of the file or of a chunk; `checked` where a CRC covers it.
    pub(super) fn record(
        &mut self,
        opcode: u8,
        body: &[u8],
        checked: bool,
        sink: &mut dyn FnMut(Event<'_>),
    ) -> Outcome {
        match opcode {
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {}
            0x01..=op::DATA_END | 0x80.. => return Ok(Ok(())),
            _ => {
                return Ok(Err(format!(
                    "there is a record of the unknown kind {opcode:#04x}"
                )));
            }
        }
        match mcap::parse_record(opcode, body) {
            Ok(Record::Schema { header, data }) => {
                let schema = Schema {
                    name: header.name,
                    encoding: header.encoding,
                    data: data.into_owned(),
                };
                self.schema(header.id, schema)
            }
            Ok(Record::Channel(channel)) => self.channel(channel),
            Ok(Record::Message { header, data }) => self.message(header, &data, checked, sink),
            Ok(_) => Ok(Ok(())),
            Err(error) => Ok(Err(format!("a record makes no sense: {error}"))),
        }
    }

    fn schema(&mut self, id: u16, schema: Schema) -> Outcome {
        if let Some(known) = self.schemas.get(&id) {
            let same = (&known.name, &known.encoding, &known.data)
                == (&schema.name, &schema.encoding, &schema.data);
            return Ok(if same {
                Ok(())
            } else {
                Err(format!("schema {id} is defined twice, and not alike"))
            });
        }
        self.hold(schema.name.len() + schema.encoding.len() + schema.data.len())?;
        self.schemas.insert(id, Arc::new(schema));
        Ok(Ok(()))
    }

    fn channel(&mut self, channel: mcap::records::Channel) -> Outcome {
        if let Some(known) = self.channels.get(&channel.id) {
            let same = (&known.topic, &known.encoding, known.schema)
                == (&channel.topic, &channel.message_encoding, channel.schema_id);
            let why = || format!("channel {} is defined twice, and not alike", channel.id);
            return Ok(if same { Ok(()) } else { Err(why()) });
        }
        self.hold(channel.topic.len() + channel.message_encoding.len())?;
        let wanted = self
            .wanted
            .iter()
            .position(|wanted| wanted.topic.name == channel.topic);
        self.channels.insert(
            channel.id,
            Channel {
                topic: channel.topic,
                encoding: channel.message_encoding,
                schema: channel.schema_id,
                messages: 0,
                wanted: wanted.map(|index| (index, None)),
            },
        );
        Ok(Ok(()))
    }

    fn message(
        &mut self,
        header: MessageHeader,
        data: &[u8],
        checked: bool,
        sink: &mut dyn FnMut(Event<'_>),
    ) -> Outcome {
        let Some(channel) = self.channels.get_mut(&header.channel_id) else {
            return Ok(Err(format!(
                "a message belongs to channel {}, which is not defined",
                header.channel_id
            )));
        };
        channel.messages += 1;
        let Some((index, decoder)) = &mut channel.wanted else {
            return Ok(Ok(()));
        };
        let counts = &mut self.counts[*index];
        let decoder = match decoder {
            Some(decoder) => decoder,
            None => {
                let schema = self.schemas.get(&channel.schema);
                if schema.is_none() && channel.schema != 0 {
                    return Ok(Err(format!(
                        "the schema of topic {} is not there",
                        channel.topic
                    )));
                }
                let text = schema.map(|schema| SchemaText {
                    name: &schema.name,
                    encoding: &schema.encoding,
                    data: &schema.data,
                });
                let TopicRequest {
                    topic,
                    more,
                    required,
                } = self.wanted[*index];
                let compiled = Decoder::compile_with(&channel.encoding, text, topic, more);
                let new = match compiled {
                    // A log is not refused for a topic that it need not have.
                    Err(error) if !required => {
                        counts.undecodable += 1;
                        counts.first_reason = error.to_string();
                        channel.wanted = None;
                        return Ok(Ok(()));
                    }
                    compiled => compiled?,
                };
                counts.unstamped |= !new.stamped();
                decoder.insert(new)
            }
        };
        let sample = decoder.decode_with(data).and_then(|(fields, more)| {
            // Known only now where there is no schema.
            counts.unstamped |= fields.stamp.is_none();
            let log_time = || i64::try_from(header.log_time).map_err(|_| DecodeError::Stamp);
            let sample = Sample {
                stamp: fields.stamp.map_or_else(log_time, Ok)?,
                x: fields.x,
                y: fields.y,
            };
            Ok((sample, more))
        });
        match sample {
            Ok((sample, more)) => {
                counts.decoded += 1;
                counts.unchecked |= !checked;
                sink(if self.wanted[*index].more.is_empty() {
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

    /// Whether any sample came from outside of a chunk with a CRC.
    pub(super) fn any_unchecked(&self) -> bool {
        self.counts.iter().any(|counts| counts.unchecked)
    }

    fn hold(&mut self, bytes: usize) -> Result<(), LogError> {
        self.held += bytes;
        if self.held <= self.limit {
            return Ok(());
        }
        Err(LogError::TooLarge {
            log: self.log.into(),
            what: "set of schemas and channels",
            offset: 0,
            size: self.held as u64,
            limit: self.limit as u64,
        })
    }

    /// What was in the file; an error where a required topic is not, unless it may have been in what is damaged or cut off.
    pub(super) fn summary(self, sha256: String, damage: Vec<Damage>) -> Result<Summary, LogError> {
        let mut topics = BTreeMap::new();
        for channel in self.channels.values() {
            let schema = self
                .schemas
                .get(&channel.schema)
                .map_or("", |schema| &schema.name);
            let count = topics
                .entry((channel.topic.clone(), schema.to_string()))
                .or_insert(0);
            *count += channel.messages;
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
            sha256,
            messages: topics.iter().map(|topic| topic.messages).sum(),
            undecodable: self
                .counts
                .iter()
                .map(|counts| (counts.undecodable, counts.first_reason.clone()))
                .collect(),
            unstamped: self.counts.iter().map(|counts| counts.unstamped).collect(),
            topics,
            damage,
        };
        for (wanted, counts) in self.wanted.iter().zip(&self.counts) {
            if wanted.required && counts.decoded == 0 && counts.undecodable > 0 {
                return Err(LogError::Undecodable {
                    log: self.log.into(),
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
                    log: self.log.into(),
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
