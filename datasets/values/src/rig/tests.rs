//! Rig files that are accepted, and what is said of those that are not.

use super::*;

/// What is said where one piece of text is replaced, for every line `FROM → TO ⇒ SAID`.
pub(super) fn refused(refusal: impl Fn(&str, &str) -> String, cases: &str) {
    for case in cases.trim().lines() {
        let case = case.replace("\\n", "\n");
        let (change, said) = case.split_once(" ⇒ ").expect("what is said");
        let (from, to) = change.split_once(" → ").expect("a change");
        let text = refusal(from, to);
        assert!(text.contains(said), "{to}: {text}");
    }
}

/// The template with one piece of text replaced, and what is then said of it.
pub(super) fn refusal(from: &str, to: &str) -> String {
    assert!(Rig::template().contains(from), "{from}");
    match Rig::parse(&Rig::template().replacen(from, to, 1)) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("accepted {to}"),
    }
}

#[test]
fn the_template_is_the_demo_rig_and_survives_a_round_trip() {
    let rig = Rig::parse(Rig::template()).expect("the template parses");
    assert_eq!(rig, Rig::demo(Shape::Cylinder));
    for shape in Shape::ALL {
        let rig = Rig::demo(shape);
        assert_eq!(Rig::parse(&rig.to_toml()).expect("parses"), rig);
    }
}

#[test]
fn topics_may_be_left_out() {
    let text = Rig::template()
        .split("[topics.centroid]")
        .next()
        .expect("text")
        .to_string();
    assert_eq!(Rig::parse(&text).expect("parses").topics, Topics::default());
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
    let text = refusal("radius = 0.030 ", "raduis = 0.030 ");
    assert!(
        text.contains("`object.raduis` on line 7") && text.contains("`object.radius`"),
        "{text}"
    );
    let text = refusal("[camera]", "[kamera]");
    assert!(
        text.contains("`kamera`") && text.contains("`camera`"),
        "{text}"
    );
    let text = refusal("mass = 0.100", "mass = 0.1\nacceleration = 5.0");
    assert!(
        text.contains("`object.acceleration`") && text.contains("`robot.acceleration`"),
        "{text}"
    );
    let text = refusal("stamp = \"header.stamp\"", "time = \"header.stamp\"");
    assert!(text.contains("`topics.centroid.time`"), "{text}");
}

#[test]
fn a_missing_key_comes_with_the_line_to_add() {
    assert!(
        refusal("mass = 0.100", "").contains("`object.mass`: add a line such as `mass = 0.100")
    );
    assert!(refusal("half_height = 0.020", "").contains("`object.half_height`"));
    assert!(refusal("[striker]", "[topics]\n[table.z]").contains("`table.z`"));
    assert!(
        Rig::parse("")
            .expect_err("empty")
            .to_string()
            .contains("`object`")
    );
    let cube = refusal("shape = \"cylinder\"", "shape = \"box\"");
    assert!(
        cube.contains("object.radius = 0.03: is no size of a box"),
        "{cube}"
    );
}

#[test]
fn a_box_needs_its_half_size() {
    let text = Rig::demo(Shape::Box).to_toml();
    let line = text.lines().find(|line| line.starts_with("half_size"));
    assert!(
        Rig::parse(&text.replace(line.expect("stated"), ""))
            .expect_err("refused")
            .to_string()
            .contains("`object.half_size`")
    );
}

#[test]
fn values_that_make_no_sense_are_refused() {
    refused(
        refusal,
        r#"
radius = 0.030 → radius = 30.0 ⇒ millimetres?
radius = 0.030 → radius = -0.03 ⇒ above 0
radius = 0.030 → radius = nan ⇒ finite
mass = 0.100 → mass = 100 ⇒ grams?
mass = 0.100 → mass = inf ⇒ finite
rate = 60.0 → rate = 0 ⇒ above 0
noise = 0.0007 → noise = 0.7 ⇒ pixels?
x = [0.10, 1.00] → x = [1.00, 0.10] ⇒ reversed
x = [0.10, 1.00] → x = [100, 1000] ⇒ millimetres?
y = [-0.60, 0.60] → y = [0.6, 0.6] ⇒ empty
speed = [0.4, 1.0] → speed = [0.0, 1.0] ⇒ above 0
speed = [0.4, 1.0] → speed = [400, 1000] ⇒ robot.speed
angle = [-0.80, 0.80] → angle = [-45, 45] ⇒ degrees?
acceleration = 5.0 → acceleration = 5000.0 ⇒ millimetres?
name = "/object/centroid" → name = "" ⇒ topics.centroid.name
shape = "cylinder" → shape = "cone" ⇒ cylinder
radius = 0.030 → radius = "big" ⇒ line 7
"#,
    );
}

#[test]
fn a_number_too_many_is_refused_and_not_passed_over() {
    let acceleration = "acceleration = 5.0";
    // A base with its height, which has a key of its own.
    let base = format!("{acceleration}\nbase = [0.0, 0.0, 0.05]");
    assert!(refusal(acceleration, &base).contains("2 numbers"));
    let table = refusal("x = [0.10, 1.00]", "x = [0.10, 1.00, 2.0]");
    assert!(table.contains("2 numbers"), "{table}");
}

#[test]
fn what_is_left_out_of_a_topic_has_its_default() {
    let start = Rig::template()
        .split("[topics.centroid]")
        .next()
        .expect("text");
    let text = format!(
        "{start}[topics.centroid]\nname = \"/puck\"\n[topics.state]\nname = \"/arm\"\nposition_x = \"p.x\"\n[topics.pose]\nstamp = \"t\"\n"
    );
    let topics = Rig::parse(&text).expect("parses").topics;
    assert_eq!(topics.centroid.name, "/puck");
    assert_eq!(topics.centroid.x, Topics::default().centroid.x);
    assert_eq!(topics.state.topic.name, "/arm");
    assert_eq!(topics.state.topic.x, "twist.twist.linear.x");
    assert_eq!(
        (
            topics.state.position_x.as_str(),
            topics.state.position_y.as_str()
        ),
        ("p.x", "pose.pose.position.y")
    );
    assert_eq!(
        (
            topics.pose.topic.name.as_str(),
            topics.pose.topic.stamp.as_str()
        ),
        ("/object/pose", "t")
    );
}

#[test]
fn the_text_of_default_topics_is_that_of_the_rig_files_before_poses_were_read() {
    let text = Rig::demo(Shape::Cylinder).to_toml();
    assert!(
        !text.contains("pose") && text.contains("[topics.state]"),
        "{text}"
    );
}

#[test]
fn keys_of_the_state_and_the_pose_are_known_and_slips_of_them_are_named() {
    refused(
        refusal,
        r#"
position_x = → positon_x = ⇒ `topics.state.position_x`
orientation = "pose.orientation" → orientaton = "pose.orientation" ⇒ `topics.pose.orientation`
[topics.pose] → [topics.poses] ⇒ `topics.pose`
"#,
    );
    let text = refusal("orientation = \"pose.orientation\"", "orientation = \" \"");
    assert!(text.contains("topics.pose.orientation"), "{text}");
}
