//! The channels of a server that matter: the object's centroid or pose, and images.

use std::collections::BTreeMap;
use std::sync::Arc;

use logs::{Decoder, RawChannel};
use values::{FieldTopic, Point, Topics};

use super::protocol::Channel;

/// Greatest number of topics of a server that an error lists, where the one that is looked for is not among them.
const MOST_LISTED: usize = 20;

/// What a channel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    Centroid,
    Pose,
    Image,
}

/// A place of the object, as a message gives it.
#[derive(Clone, Debug)]
pub(super) struct Sighting {
    pub(super) point: Point,
    pub(super) yaw: Option<f64>,
    /// Its height in m; none where the message has none.
    pub(super) z: Option<f64>,
    /// The name of the frame that it is in; empty where the message has none.
    pub(super) frame: String,
    /// The message's stamp, in ns; none where it has none.
    pub(super) stamp: Option<i64>,
}

#[derive(Debug)]
pub(super) struct Subscription {
    pub(super) role: Role,
    channel: Channel,
    pub(super) raw: Arc<RawChannel>,
    /// The decoder of the object's place; none for images.
    decoder: Option<Decoder>,
}

/// The channels that are listened to, by the ids of their subscriptions, which are chosen here.
#[derive(Debug)]
pub(super) struct Channels {
    topics: Topics,
    listened: BTreeMap<u32, Subscription>,
    next: u32,
    /// Some names of the server's other topics, for errors.
    others: Vec<String>,
}

impl Channels {
    /// Whether a channel of this role is listened to.
    pub(super) fn has(&self, role: Role) -> bool {
        self.listened.values().any(|channel| channel.role == role)
    }

    pub(super) fn new(topics: &Topics) -> Self {
        Self {
            topics: topics.clone(),
            listened: BTreeMap::new(),
            next: 1,
            others: Vec::new(),
        }
    }

    /// Takes a channel that a server advertises; gives the id of the subscription to make where it is to be listened to. Errors where
    /// it contradicts what is known.
    pub(super) fn advertise(&mut self, channel: Channel) -> Result<Option<u32>, String> {
        let Some(role) = self.role(&channel.topic) else {
            if self.others.len() < MOST_LISTED {
                self.others.push(channel.topic);
            }
            return Ok(None);
        };
        for known in self.listened.values() {
            if known.channel == channel {
                return Ok(None);
            }
            if known.channel.id == channel.id {
                return Err(format!(
                    "channel {} is advertised twice, with different contents",
                    channel.id
                ));
            }
            if known.role == role {
                return Err(format!(
                    "topic {} is there twice, as channels {} and {}: two programs publish it; end one of them",
                    channel.topic, known.channel.id, channel.id
                ));
            }
        }
        let schema = channel.schema()?;
        let raw = RawChannel {
            id: self.next as u16,
            topic: channel.topic.clone(),
            encoding: channel.encoding.clone(),
            schema: channel.schema_name.clone(),
            schema_encoding: channel.schema_encoding().into(),
            schema_data: schema.into(),
        };
        let listened = Subscription {
            role,
            decoder: self.decoder(role, &raw)?,
            raw: Arc::new(raw),
            channel,
        };
        let subscription = self.next;
        self.listened.insert(subscription, listened);
        // A log's channels have numbers of 16 bits: a server that goes on for ever is no server of topics.
        if self.next >= u32::from(u16::MAX) {
            return Err("its channels come and go without end".into());
        }
        self.next += 1;
        Ok(Some(subscription))
    }

    pub(super) fn unadvertise(&mut self, ids: &[u64]) {
        self.listened
            .retain(|_, listened| !ids.contains(&listened.channel.id));
    }

    pub(super) fn of(&self, subscription: u32) -> Option<&Subscription> {
        self.listened.get(&subscription)
    }

    /// Which topic gives the object's place: its centroid's, as where logs are read, else its pose's; none where neither is there.
    pub(super) fn object(&self) -> Option<Role> {
        self.listened
            .values()
            .map(|listened| listened.role)
            .filter(|role| *role != Role::Image)
            .min()
    }

    pub(super) fn names(&self) -> String {
        let listened = self
            .listened
            .values()
            .map(|known| known.channel.topic.clone());
        let names: Vec<String> = listened.chain(self.others.iter().cloned()).collect();
        if names.is_empty() {
            "no topics at all".into()
        } else {
            names.join(", ")
        }
    }

    fn role(&self, topic: &str) -> Option<Role> {
        let Topics {
            centroid,
            pose,
            image,
            ..
        } = &self.topics;
        if topic == centroid.name {
            Some(Role::Centroid)
        } else if topic == pose.topic.name {
            Some(Role::Pose)
        } else if image.as_ref().is_some_and(|image| image.name == topic) {
            Some(Role::Image)
        } else {
            None
        }
    }

    /// The decoder that reads the same topic of a log.
    fn decoder(&self, role: Role, raw: &RawChannel) -> Result<Option<Decoder>, String> {
        let orientation = &self.topics.pose.orientation;
        let (topic, turn): (&FieldTopic, Vec<String>) = match role {
            Role::Image => return Ok(None),
            Role::Centroid => (&self.topics.centroid, Vec::new()),
            Role::Pose => {
                let parts = ["x", "y", "z", "w"].map(|part| format!("{orientation}.{part}"));
                (&self.topics.pose.topic, parts.into())
            }
        };
        let more: Vec<String> = turn.into_iter().chain(height(topic)).collect();
        let frame = frame(topic);
        Decoder::compile_with(&raw.encoding, raw.schema(), topic, &more, Some(&frame))
            .map(Some)
            .map_err(|error| format!("failed to {error}"))
    }
}

/// The path of the height: beside the first coordinate's, where that is called x.
fn height(topic: &FieldTopic) -> Option<String> {
    let beside = topic.x.strip_suffix('x')?;
    let is_name = beside.is_empty() || beside.ends_with('.');
    is_name.then(|| format!("{beside}z"))
}

/// The path of the frame's name: beside the stamp's, as in ROS's headers and in Foxglove's messages.
fn frame(topic: &FieldTopic) -> String {
    let beside = topic.stamp.rfind('.').map_or(0, |dot| dot + 1);
    format!("{}frame_id", &topic.stamp[..beside])
}

impl Subscription {
    /// The object's place in a message; none of an image. Errors where the message makes no sense.
    pub(super) fn read(&self, message: &[u8]) -> Result<Option<Sighting>, String> {
        let Some(decoder) = &self.decoder else {
            return Ok(None);
        };
        let (fields, more, frame) = decoder
            .decode_with(message)
            .map_err(|error| format!("a message of topic {}: {error}", self.channel.topic))?;
        let point = Point::new(fields.x, fields.y);
        if !(point.x.is_finite() && point.y.is_finite()) {
            return Err(format!(
                "a message of topic {} holds no finite place",
                self.channel.topic
            ));
        }
        let (yaw, z) = match self.role {
            Role::Pose => {
                let [turn @ .., z] = more;
                (ingest::yaw_of(turn), z)
            }
            _ => (None, more[0]),
        };
        Ok(Some(Sighting {
            point,
            yaw,
            z: Some(z).filter(|z| z.is_finite()),
            frame: frame.unwrap_or_default(),
            stamp: fields.stamp,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(id: u64, topic: &str) -> Channel {
        let text = format!(r#"{{"id":{id},"topic":"{topic}","encoding":"json"}}"#);
        serde_json::from_str(&text).expect("a channel")
    }

    #[test]
    fn the_centroid_is_listened_to_before_the_pose_and_others_are_not() {
        let mut channels = Channels::new(&Topics::default());
        assert_eq!(channels.advertise(channel(9, "/tf")), Ok(None));
        assert_eq!(channels.object(), None);
        assert_eq!(channels.advertise(channel(4, "/object/pose")), Ok(Some(1)));
        assert_eq!(channels.object(), Some(Role::Pose));
        assert_eq!(
            channels.advertise(channel(7, "/object/centroid")),
            Ok(Some(2))
        );
        assert_eq!(channels.object(), Some(Role::Centroid));
        assert_eq!(channels.names(), "/object/pose, /object/centroid, /tf");
        // The same again is no second one; after it went, it may come back by another id.
        assert_eq!(channels.advertise(channel(7, "/object/centroid")), Ok(None));
        channels.unadvertise(&[7]);
        assert_eq!(channels.object(), Some(Role::Pose));
        assert_eq!(
            channels.advertise(channel(8, "/object/centroid")),
            Ok(Some(3))
        );
        let sighting = channels
            .of(3)
            .expect("there")
            .read(br#"{"point":{"x":0.3,"y":-0.1}}"#)
            .expect("read")
            .expect("a place");
        assert_eq!(sighting.point, Point::new(0.3, -0.1));
        assert_eq!(sighting.stamp, None);
    }

    #[test]
    fn channels_that_contradict_each_other_are_reported() {
        let mut channels = Channels::new(&Topics::default());
        assert_eq!(
            channels.advertise(channel(7, "/object/centroid")),
            Ok(Some(1))
        );
        let twice = channels.advertise(channel(8, "/object/centroid"));
        assert!(twice.expect_err("two").contains("two programs"));
        let other = channels.advertise(channel(7, "/object/pose"));
        assert!(other.expect_err("one id").contains("different contents"));
    }

    #[test]
    fn messages_that_make_no_sense_are_reported() {
        let mut channels = Channels::new(&Topics::default());
        let id = channels.advertise(channel(7, "/object/centroid"));
        let listened = channels
            .of(id.expect("taken").expect("new"))
            .expect("there");
        for wrong in [&b""[..], b"{", br#"{"point":{"x":1}}"#, b"\xff\xff"] {
            assert!(listened.read(wrong).is_err(), "{wrong:?}");
        }
    }
}
