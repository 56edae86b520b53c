//! The text of ROS message definitions, as MCAP files embed them (`ros2msg`, `ros1msg`): the type's own definition,
//! then every type it uses, each behind a line of `=` and a line `MSG: package/Name`.
//! Source: MCAP's registry of schema encodings; ROS 2's interface definition.

/// A type's members in order.
#[derive(Debug)]
pub(super) struct Definition {
    pub(super) name: String,
    pub(super) members: Vec<Member>,
}

#[derive(Debug)]
pub(super) struct Member {
    pub(super) name: String,
    pub(super) base: Base,
    pub(super) shape: Shape,
}

/// What a member, or each element of it, is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Base {
    Number(Primitive),
    Text,
    WideText,
    /// A type by the name that the text gives it.
    Named(String),
}

/// Numbers that have a fixed size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Primitive {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Primitive {
    pub(super) fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// How many of its base a member holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    One,
    Array(usize),
    Sequence,
}

/// Every definition in a schema's text, the type's own first.
pub(super) fn parse(name: &str, text: &str) -> Result<Vec<Definition>, String> {
    let mut definitions = vec![Definition {
        name: plain_name(name),
        members: Vec::new(),
    }];
    for line in text.lines() {
        let line = line.trim();
        if line.len() >= 3 && line.bytes().all(|byte| byte == b'=') {
            continue;
        }
        if let Some(name) = line.strip_prefix("MSG:") {
            definitions.push(Definition {
                name: plain_name(name.trim()),
                members: Vec::new(),
            });
        } else if line.starts_with("IDL:") {
            return Err("it is written in OMG IDL, and only message definitions are read".into());
        } else if line.starts_with("SRV:") {
            return Err("it defines a service, and only message definitions are read".into());
        } else if let Some(member) = parse_member(line)?
            && let Some(definition) = definitions.last_mut()
        {
            definition.members.push(member);
        }
    }
    Ok(definitions)
}

/// The member that a line defines; `None` for a comment, a constant or an empty line.
fn parse_member(line: &str) -> Result<Option<Member>, String> {
    if line.is_empty() || line.starts_with('#') {
        return Ok(None);
    }
    let Some((kind, rest)) = line.split_once(char::is_whitespace) else {
        return Err(format!("the line `{}` names no field", excerpt(line)));
    };
    let rest = rest.trim_start();
    let end = rest
        .find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .unwrap_or(rest.len());
    let (name, after) = rest.split_at(end);
    if name.is_empty() {
        return Err(format!("the line `{}` names no field", excerpt(line)));
    }
    if after.trim_start().starts_with('=') {
        return Ok(None);
    }
    let (base, shape) = parse_shape(kind)?;
    Ok(Some(Member {
        name: name.into(),
        base: parse_base(base),
        shape,
    }))
}

fn parse_shape(kind: &str) -> Result<(&str, Shape), String> {
    let Some((base, bracket)) = kind.split_once('[') else {
        return Ok((kind, Shape::One));
    };
    let wrong = || format!("`{}` is no type", excerpt(kind));
    let count = bracket.strip_suffix(']').ok_or_else(wrong)?;
    if count.is_empty() {
        return Ok((base, Shape::Sequence));
    }
    if let Some(bound) = count.strip_prefix("<=") {
        bound.parse::<u32>().map_err(|_| wrong())?;
        return Ok((base, Shape::Sequence));
    }
    match count.parse::<u32>() {
        Ok(count) if count > 0 => Ok((base, Shape::Array(count as usize))),
        _ => Err(wrong()),
    }
}

fn parse_base(base: &str) -> Base {
    // A bounded string is a string on the wire.
    match base.split("<=").next().unwrap_or(base) {
        "bool" => Base::Number(Primitive::Bool),
        "int8" => Base::Number(Primitive::I8),
        "uint8" | "byte" | "char" => Base::Number(Primitive::U8),
        "int16" => Base::Number(Primitive::I16),
        "uint16" => Base::Number(Primitive::U16),
        "int32" => Base::Number(Primitive::I32),
        "uint32" => Base::Number(Primitive::U32),
        "int64" => Base::Number(Primitive::I64),
        "uint64" => Base::Number(Primitive::U64),
        "float32" => Base::Number(Primitive::F32),
        "float64" => Base::Number(Primitive::F64),
        "string" => Base::Text,
        "wstring" => Base::WideText,
        named => Base::Named(plain_name(named)),
    }
}

/// `package/Name` for `package/msg/Name`.
fn plain_name(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A piece of text short enough for an error.
fn excerpt(text: &str) -> String {
    text.chars().take(60).collect()
}

/// The index of the definition that a name means when used within `package/Name`, if the text holds it.
pub(super) fn resolve(definitions: &[Definition], user: &str, name: &str) -> Option<usize> {
    let find = |wanted: &str| {
        definitions
            .iter()
            .position(|definition| definition.name == wanted)
    };
    if name.contains('/') {
        return find(name);
    }
    let package = user.split('/').next().unwrap_or_default();
    find(&format!("{package}/{name}"))
        .or_else(|| {
            if name == "Header" {
                find("std_msgs/Header")
            } else {
                None
            }
        })
        .or_else(|| {
            let suffix = format!("/{name}");
            definitions
                .iter()
                .position(|definition| definition.name.ends_with(&suffix))
        })
}

/// Members of the types that need no definition in the text: stamps and durations.
pub(super) fn built_in(name: &str) -> Option<Vec<Member>> {
    let (seconds, nanoseconds, kinds) = match name {
        "time" => ("secs", "nsecs", [Primitive::U32, Primitive::U32]),
        "duration" => ("secs", "nsecs", [Primitive::I32, Primitive::I32]),
        "builtin_interfaces/Time" | "builtin_interfaces/Duration" => {
            ("sec", "nanosec", [Primitive::I32, Primitive::U32])
        }
        _ => return None,
    };
    let members = [seconds, nanoseconds].into_iter().zip(kinds);
    Some(
        members
            .map(|(name, kind)| Member {
                name: name.into(),
                base: Base::Number(kind),
                shape: Shape::One,
            })
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_comments_defaults_and_bounds_are_understood() {
        let text = "# a comment\nint32 LIMIT=5\nstring NAME = \"a # b\"\nfloat64 x 1.5 # with default\n\
                    string<=10 label \"hi\"\nint32[<=3] few\nuint8[] many\nfloat32[9] nine\npkg/msg/Other other\n\
                    ================\nMSG: pkg/Other\nbool yes\n";
        let definitions = parse("pkg/msg/Root", text).expect("parses");
        let members: Vec<_> = definitions[0]
            .members
            .iter()
            .map(|m| (m.name.as_str(), m.shape))
            .collect();
        assert_eq!(
            members,
            [
                ("x", Shape::One),
                ("label", Shape::One),
                ("few", Shape::Sequence),
                ("many", Shape::Sequence),
                ("nine", Shape::Array(9)),
                ("other", Shape::One)
            ]
        );
        assert_eq!(definitions[0].members[1].base, Base::Text);
        assert_eq!(resolve(&definitions, "pkg/Root", "Other"), Some(1));
    }

    #[test]
    fn lines_that_are_no_definition_are_errors() {
        for text in [
            "float64",
            "float64 =",
            "float64[ x",
            "float64[0] x",
            "float64[<=x] y",
            "IDL: a/b",
            "int32[-1] x",
        ] {
            assert!(parse("a/B", text).is_err(), "{text}");
        }
    }
}
