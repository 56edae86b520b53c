//! Dotted field paths, and the tree of what is wanted of one message.

use values::FieldTopic;

use crate::LogError;

/// A part of a sample that a field of a message holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Leaf {
    /// The stamp as a whole: a message of seconds and nanoseconds, float seconds or integer nanoseconds.
    Stamp,
    /// The stamp's whole seconds.
    Seconds,
    /// The stamp's nanoseconds past them.
    Nanoseconds,
    /// First coordinate.
    X,
    /// Second coordinate.
    Y,
    /// A further number, by its place among those asked for.
    More(usize),
    Text,
}

/// What is wanted of a message or of one of its fields: leaves here, and what lies below.
#[derive(Clone, Debug, Default)]
pub(crate) struct FieldTree {
    /// What this field itself holds.
    pub(crate) leaves: Vec<Leaf>,
    /// Wanted members by name.
    pub(crate) fields: Vec<(String, FieldTree)>,
    /// Wanted elements by index from 0.
    pub(crate) elements: Vec<(usize, FieldTree)>,
}

/// Names that are in use for the seconds of a stamp.
pub(crate) const SECONDS: [&str; 3] = ["sec", "secs", "seconds"];
/// Names that are in use for the nanoseconds of a stamp.
pub(crate) const NANOSECONDS: [&str; 6] = [
    "nanosec",
    "nanosecs",
    "nsec",
    "nsecs",
    "nanos",
    "nanoseconds",
];

/// What a message stamp's member of this name holds.
pub(crate) fn stamp_leaf(member: &str) -> Option<Leaf> {
    if SECONDS.contains(&member) {
        Some(Leaf::Seconds)
    } else if NANOSECONDS.contains(&member) {
        Some(Leaf::Nanoseconds)
    } else {
        None
    }
}

pub(crate) fn first_name(path: &str) -> &str {
    path.split(['.', '[']).next().unwrap_or(path)
}

impl Leaf {
    /// The error of a path that leads nowhere.
    pub(crate) fn astray(self, topic: &FieldTopic, why: String) -> LogError {
        let path = match self {
            // Further paths that lead nowhere are given up, not reported.
            Self::X | Self::More(_) | Self::Text => &topic.x,
            Self::Y => &topic.y,
            Self::Stamp | Self::Seconds | Self::Nanoseconds => &topic.stamp,
        };
        LogError::Field {
            topic: topic.name.clone(),
            path: path.clone(),
            why,
        }
    }
}

impl FieldTree {
    /// A field that is wanted itself.
    pub(crate) fn leaf(leaf: Leaf) -> Self {
        Self {
            leaves: vec![leaf],
            ..Self::default()
        }
    }

    /// What is wanted of a message with these members where this is the stamp, and where that message is one: two members with the names
    /// of its parts.
    pub(crate) fn of_stamp(&self, members: impl Iterator<Item = String>) -> Option<Self> {
        let part = |name: String| Some((name.clone(), Self::leaf(stamp_leaf(&name)?)));
        let fields: Vec<_> = members.filter_map(part).collect();
        (self.leaves.contains(&Leaf::Stamp) && fields.len() == 2).then(|| Self {
            fields,
            ..Self::default()
        })
    }

    pub(crate) fn is_text(&self) -> bool {
        self.leaves == [Leaf::Text] && self.fields.is_empty() && self.elements.is_empty()
    }

    /// Some leaf at or below here, to say which path went astray.
    pub(crate) fn any_leaf(&self) -> Leaf {
        let below = self
            .fields
            .iter()
            .map(|(_, want)| want)
            .chain(self.elements.iter().map(|(_, want)| want));
        self.leaves
            .first()
            .copied()
            .or_else(|| below.map(Self::any_leaf).next())
            .unwrap_or(Leaf::Stamp)
    }

    /// The tree for a topic's stamp, x, y and further fields, or for those without the stamp.
    pub(crate) fn of(
        topic: &FieldTopic,
        further: &[(Leaf, &str)],
        stamped: bool,
    ) -> Result<Self, LogError> {
        let mut root = Self::default();
        let paths = [
            (Leaf::Stamp, topic.stamp.as_str()),
            (Leaf::X, &topic.x),
            (Leaf::Y, &topic.y),
        ];
        for (leaf, path) in paths.iter().chain(further).copied() {
            if stamped || leaf != Leaf::Stamp {
                let steps = parse(path).map_err(|why| LogError::Field {
                    topic: topic.name.clone(),
                    path: path.into(),
                    why: why.into(),
                })?;
                root.add(&steps, leaf);
            }
        }
        Ok(root)
    }

    fn add(&mut self, steps: &[PathStep], leaf: Leaf) {
        let next = match steps.first() {
            None => return self.leaves.push(leaf),
            Some(PathStep::Name(name)) => child(&mut self.fields, name.clone()),
            Some(PathStep::Index(index)) => child(&mut self.elements, *index),
        };
        next.add(&steps[1..], leaf);
    }
}

fn child<K: PartialEq>(children: &mut Vec<(K, FieldTree)>, key: K) -> &mut FieldTree {
    let at = children
        .iter()
        .position(|(known, _)| *known == key)
        .unwrap_or_else(|| {
            children.push((key, FieldTree::default()));
            children.len() - 1
        });
    &mut children[at].1
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PathStep {
    Name(String),
    Index(usize),
}

/// The steps of a path such as `poses[0].position.x`.
pub(crate) fn parse(path: &str) -> Result<Vec<PathStep>, &'static str> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (name, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.trim().is_empty() {
            return Err("a name is empty; write names with one dot between them");
        }
        steps.push(PathStep::Name(name.into()));
        while !rest.is_empty() {
            let (index, after) = rest
                .strip_prefix('[')
                .and_then(|inner| inner.split_once(']'))
                .ok_or("an index lacks its `]`")?;
            steps.push(PathStep::Index(
                index
                    .parse()
                    .map_err(|_| "an index is no whole number from 0")?,
            ));
            rest = after;
        }
    }
    Ok(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_names_and_indices() {
        let name = |text: &str| PathStep::Name(text.into());
        assert_eq!(parse("point.x"), Ok(vec![name("point"), name("x")]));
        assert_eq!(
            parse("a[2][0].b"),
            Ok(vec![
                name("a"),
                PathStep::Index(2),
                PathStep::Index(0),
                name("b")
            ])
        );
        for wrong in ["", "a..b", "a[", "a[-1]", "a[1]b", "[0]"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
