use values::FieldTopic;

use super::super::{DecodeError, Decoder, Fields, SchemaText};
use crate::LogError;

const POINT_STAMPED: &str = "std_msgs/Header header\ngeometry_msgs/Point point\n\
    ====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";

fn topic(x: &str, y: &str) -> FieldTopic {
    FieldTopic {
        name: "/t".into(),
        stamp: "header.stamp".into(),
        x: x.into(),
        y: y.into(),
    }
}

fn compile(text: &str, x: &str, y: &str) -> Result<Decoder, LogError> {
    let schema = SchemaText {
        name: "pkg/msg/Root",
        encoding: "ros2msg",
        data: text.as_bytes(),
    };
    Decoder::compile("cdr", Some(schema), &topic(x, y))
}

/// A CDR message, written as any ROS 2 node would, with either endianness.
struct Cdr(Vec<u8>, bool);

impl Cdr {
    fn new(big_endian: bool) -> Self {
        Self(vec![0, u8::from(!big_endian), 0, 0], big_endian)
    }

    fn put<const N: usize>(mut self, little: [u8; N]) -> Self {
        while !(self.0.len() - 4).is_multiple_of(N) {
            self.0.push(0xAA);
        }
        let mut bytes = little;
        if self.1 {
            bytes.reverse();
        }
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Self {
        let mut cdr = self.put((text.len() as u32 + 1).to_le_bytes());
        cdr.0.extend(text.bytes().chain([0]));
        cdr
    }

    fn header(self) -> Self {
        self.put(7_i32.to_le_bytes())
            .put(9_u32.to_le_bytes())
            .text("table")
    }
}

#[test]
fn both_endiannesses_are_read_with_cdr_alignment() {
    let decoder = compile(POINT_STAMPED, "point.x", "point.y").expect("compiles");
    for big_endian in [false, true] {
        let message = Cdr::new(big_endian)
            .header()
            .put(1.5_f64.to_le_bytes())
            .put((-2.5_f64).to_le_bytes());
        let expected = Fields {
            stamp: Some(7_000_000_009),
            x: 1.5,
            y: -2.5,
        };
        assert_eq!(decoder.decode(&message.0), Ok(expected));
        for length in 0..message.0.len() {
            assert!(decoder.decode(&message.0[..length]).is_err());
        }
    }
}

#[test]
fn everything_that_may_stand_before_a_field_is_passed_over() {
    let text = "int8 LIMIT=3\nstring[<=4] names\nbool flag\nInner[2] pair\nuint16[3] triple\nInner[] many\n\
        Empty nothing\nbyte[] bytes\nfloat64[] none\nuint8 tiny 7\nfloat32 x\nint64 y\nwstring after\n\
        ====\nMSG: pkg/Inner\nuint8 a\nstring<=9 b\nint16 c\n====\nMSG: pkg/Empty\n";
    let decoder = compile(text, "x", "y").expect("compiles");
    let inner = |cdr: Cdr| cdr.put([1]).text("abc").put(5_i16.to_le_bytes());
    let mut cdr = Cdr::new(false)
        .put(2_u32.to_le_bytes())
        .text("one")
        .text("")
        .put([1]);
    cdr = inner(inner(cdr));
    cdr = cdr
        .put(1_u16.to_le_bytes())
        .put(2_u16.to_le_bytes())
        .put(3_u16.to_le_bytes());
    cdr = inner(cdr.put(1_u32.to_le_bytes())).put([0]);
    cdr = cdr
        .put(3_u32.to_le_bytes())
        .put([1])
        .put([2])
        .put([3])
        .put(0_u32.to_le_bytes())
        .put([7]);
    cdr = cdr.put(0.5_f32.to_le_bytes()).put((-4_i64).to_le_bytes());
    assert_eq!(
        decoder.decode(&cdr.0),
        Ok(Fields {
            stamp: None,
            x: 0.5,
            y: -4.0
        })
    );
    assert!(!decoder.stamped());
}

#[test]
fn elements_of_arrays_and_sequences_can_be_wanted() {
    let text = "std_msgs/Header header\nPose[] poses\nfloat64[3] v\n====\nMSG: std_msgs/Header\ntime stamp\n\
        string frame_id\n====\nMSG: pkg/Pose\nstring name\nfloat64 x\n";
    let decoder = compile(text, "poses[1].x", "v[2]").expect("compiles");
    let mut cdr = Cdr::new(false).header().put(3_u32.to_le_bytes());
    for x in [1.0_f64, 2.0, 3.0] {
        cdr = cdr.text("p").put(x.to_le_bytes());
    }
    for v in [4.0_f64, 5.0, 6.0] {
        cdr = cdr.put(v.to_le_bytes());
    }
    assert_eq!(
        decoder.decode(&cdr.0),
        Ok(Fields {
            stamp: Some(7_000_000_009),
            x: 2.0,
            y: 6.0
        })
    );
    let none = Cdr::new(false).header().put(0_u32.to_le_bytes());
    let none = [4.0_f64, 5.0, 6.0]
        .into_iter()
        .fold(none, |cdr, v| cdr.put(v.to_le_bytes()));
    assert_eq!(decoder.decode(&none.0), Err(DecodeError::Absent("x")));
}

#[test]
fn ros_1_messages_have_no_header_and_no_alignment() {
    let text = "Header header\nfloat64 x\nfloat64 y\n====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
    let schema = SchemaText {
        name: "pkg/Root",
        encoding: "ros1msg",
        data: text.as_bytes(),
    };
    let decoder = Decoder::compile("ros1", Some(schema), &topic("x", "y")).expect("compiles");
    let mut data = [1_u32, 7, 9, 3].map(u32::to_le_bytes).concat();
    data.extend(b"abc");
    data.extend([1.5_f64, 2.5].map(f64::to_le_bytes).concat());
    assert_eq!(
        decoder.decode(&data),
        Ok(Fields {
            stamp: Some(7_000_000_009),
            x: 1.5,
            y: 2.5
        })
    );
}

#[test]
fn lying_lengths_end_with_the_message() {
    let text = "Inner[] many\nstring s\nInner[4000000000] array\nfloat64 x\nfloat64 y\n====\nMSG: pkg/Inner\nEmpty[4000000000] a\n\
        ====\nMSG: pkg/Empty\n";
    let decoder = compile(text, "x", "y").expect("compiles");
    let huge = Cdr::new(false).put(u32::MAX.to_le_bytes()).put([1_u8]);
    assert!(matches!(
        decoder.decode(&huge.0),
        Err(DecodeError::Short(_))
    ));
    let text = Cdr::new(false)
        .put(0_u32.to_le_bytes())
        .put(u32::MAX.to_le_bytes());
    assert!(matches!(
        decoder.decode(&text.0),
        Err(DecodeError::Short(_))
    ));
}

#[test]
fn schemas_that_recurse_or_explode_are_errors() {
    let why = |text: &str| compile(text, "x", "y").expect_err("refused").to_string();
    assert!(why("A a\nfloat64 x\nfloat64 y\n===\nMSG: pkg/A\nA[] a\n").contains("holds itself"));
    assert!(
        why("A a\nfloat64 x\nfloat64 y\n===\nMSG: pkg/A\nB b\n===\nMSG: pkg/B\nA a\n")
            .contains("holds itself")
    );
    assert!(why("Root[] a\nfloat64 x\nfloat64 y\n").contains("holds itself"));
    let chain = |links: usize, uses: usize| {
        let mut text = "T0 a\nfloat64 x\nfloat64 y\n".to_string();
        for link in 0..links {
            text += &format!(
                "===\nMSG: pkg/T{link}\n{}",
                format!("T{} a\n", link + 1).repeat(uses)
            );
        }
        text + &format!("===\nMSG: pkg/T{links}\nuint8 a\n")
    };
    assert!(why(&chain(100_000, 1)).contains("deeper"));
    // Thirty levels of twenty members each: compiled once a type, run no longer than the message.
    let decoder = compile(&chain(25, 20), "x", "y").expect("compiles");
    assert!(matches!(
        decoder.decode(&[0; 10_000]),
        Err(DecodeError::Short(_))
    ));
    let path = format!("a{}.x", ".a".repeat(200));
    let loops = "A a\nfloat64 y\n===\nMSG: pkg/A\nA a\nfloat64 x\n";
    assert!(compile(loops, &path, "y").is_err());
}

#[test]
fn paths_that_lead_nowhere_list_what_is_there() {
    let why = |x: &str, y: &str| {
        compile(POINT_STAMPED, x, y)
            .expect_err("refused")
            .to_string()
    };
    let text = why("point.u", "point.y");
    assert!(
        text.contains("`point.u`") && text.contains("geometry_msgs/Point has no `u` but x, y, z"),
        "{text}"
    );
    assert!(why("point", "point.y").contains("not a number"));
    assert!(why("point.x.z", "point.y").contains("below a number"));
    assert!(why("header.frame_id", "point.y").contains("text"));
    assert!(why("point[0].x", "point.y").contains("`point[0].x`"));
    assert!(why("point..x", "point.y").contains("empty"));
}

#[test]
fn a_wstring_is_an_error_only_where_it_must_be_passed() {
    let before = compile("wstring w\nfloat64 x\nfloat64 y\n", "x", "y").expect("compiles");
    assert_eq!(before.decode(&[0; 64]), Err(DecodeError::WideText));
    let after = compile("float64 x\nfloat64 y\nwstring w\n", "x", "y").expect("compiles");
    let message = Cdr::new(false)
        .put(1_f64.to_le_bytes())
        .put(2_f64.to_le_bytes());
    assert!(after.decode(&message.0).is_ok());
}

#[test]
fn other_encodings_are_named() {
    let schema = SchemaText {
        name: "a/msg/B",
        encoding: "ros2idl",
        data: b"module a {}",
    };
    let error = Decoder::compile("cdr", Some(schema), &topic("x", "y")).expect_err("refused");
    assert!(
        error.to_string().contains("`cdr` with a `ros2idl` schema"),
        "{error}"
    );
    let parameter_list = compile(POINT_STAMPED, "point.x", "point.y")
        .expect("compiles")
        .decode(&[0, 3, 0, 0, 1]);
    assert_eq!(parameter_list, Err(DecodeError::Representation(3)));
}

#[test]
fn a_text_and_further_numbers_are_read_where_the_schema_has_them() {
    let read = |schema: &str, more: &[&str], text: &str| {
        let schema = SchemaText {
            name: "pkg/msg/Root",
            encoding: "ros2msg",
            data: schema.as_bytes(),
        };
        let more: Vec<String> = more.iter().map(|path| (*path).into()).collect();
        let topic = topic("point.x", "point.y");
        let decoder = Decoder::compile_with("cdr", Some(schema), &topic, &more, Some(text));
        let message = [1.5_f64, -2.5, 0.02]
            .into_iter()
            .fold(Cdr::new(false).header(), |cdr, v| cdr.put(v.to_le_bytes()));
        let decoder = decoder.expect("compiles");
        let (fields, more, text) = decoder.decode_with(&message.0).expect("is read");
        assert_eq!((fields.x, fields.y), (1.5, -2.5));
        assert!(
            decoder.decode_with(&message.0[..14]).is_err(),
            "cut in its text"
        );
        (more, text)
    };
    let (more, text) = read(POINT_STAMPED, &["point.z"], "header.frame_id");
    assert_eq!((more[0], text.as_deref()), (0.02, Some("table")));
    // What is not there leaves the others.
    let (more, text) = read(POINT_STAMPED, &["point.w", "point.z"], "header.name");
    assert!(more[0].is_nan() && more[1] == 0.02 && text.is_none());
    let (_, text) = read(POINT_STAMPED, &[], "point.z");
    assert_eq!(text, None, "a number is no text");
}
