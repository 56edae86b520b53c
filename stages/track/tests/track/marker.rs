//! A marker on the object: its place and yaw, and what is said where it is not read.

use track::{Image, Reason, Tracker};
use values::{Colour, Marker, Point, Rig, Shape};

/// OpenCV's marker 0 of `DICT_4X4_50`, as its drawing shows it: white is 1, row by row.
const CODE: u16 = 0xb532;
/// The camera looks straight down from here, in m, with this focal length in px.
const FROM: [f64; 3] = [0.5, 0.1, 1.2];
const FOCAL: f64 = 500.0;
const SIZE: [usize; 2] = [640, 480];

fn rig() -> Rig {
    let mut rig = Rig::demo(Shape::Cylinder);
    let h = std::f64::consts::FRAC_1_SQRT_2;
    rig.camera.matrix = Some([FOCAL, FOCAL, 320.0, 240.0]);
    rig.camera.position = Some(FROM);
    rig.camera.orientation = Some([-h, h, 0.0, 0.0]);
    rig.object.marker = Some(Marker {
        dictionary: "DICT_4X4_50".into(),
        id: 0,
        size: 0.036,
        offset: Point::new(0.003, -0.002),
        yaw: 0.4,
    });
    rig
}

/// What is drawn: an object's centre and yaw, and whether its marker has come off.
type Drawn = (Point, f64, bool);

/// Grey bytes of a table with red discs 40 mm tall, each with its marker.
fn draw(rig: &Rig, objects: &[Drawn]) -> Image {
    const RAYS: usize = 5;
    let [width, height] = SIZE;
    let mut rgb = Vec::with_capacity(3 * width * height);
    for row in 0..height {
        for column in 0..width {
            let mut sum = [0.0; 3];
            for ray in 0..RAYS * RAYS {
                let part = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
                let (u, v) = (
                    column as f64 + part(ray % RAYS),
                    row as f64 + part(ray / RAYS),
                );
                // The point of the plane at a height that is seen there.
                let at = |z: f64| {
                    let far = (FROM[2] - z) / FOCAL;
                    Point::new(FROM[0] - (v - 240.0) * far, FROM[1] - (u - 320.0) * far)
                };
                let seen = objects.iter().find_map(|object| light(rig, object, &at));
                let seen = seen.unwrap_or([0.30, 0.30, 0.28]);
                sum = [0, 1, 2].map(|i| sum[i] + seen[i]);
            }
            let byte = |light: f64| {
                let light = light / (RAYS * RAYS) as f64;
                (255.0 * (1.055 * light.powf(1.0 / 2.4) - 0.055)).round() as u8
            };
            rgb.extend(sum.map(byte));
        }
    }
    Image {
        width,
        height,
        rgb,
        grey: false,
    }
}

fn light(rig: &Rig, (centre, yaw, is_bare): &Drawn, at: &dyn Fn(f64) -> Point) -> Option<[f64; 3]> {
    let marker = rig.object.marker.as_ref()?;
    let top = at(0.04);
    if top.distance(*centre) > 0.03 {
        // Its side.
        let is_side = (0..8).any(|k| at(0.005 * f64::from(k)).distance(*centre) < 0.03);
        return is_side.then_some([0.2, 0.015, 0.015]);
    }
    let turned = |x: f64, y: f64, by: f64| {
        let (sin, cos) = by.sin_cos();
        [cos * x + sin * y, -sin * x + cos * y]
    };
    let [x, y] = turned(top.x - centre.x, top.y - centre.y, *yaw);
    let [x, y] = turned(x - marker.offset.x, y - marker.offset.y, marker.yaw);
    // Cells from the upper left corner, with the border's.
    let cell = marker.size / 6.0;
    let (column, row) = ((x / cell + 3.0).floor(), (3.0 - y / cell).floor());
    let is_in = |low: f64, high: f64| [column, row].iter().all(|part| (low..high).contains(part));
    if *is_bare {
        return Some([0.5, 0.03, 0.03]);
    }
    let is_white = if is_in(1.0, 5.0) {
        let bit = 15 - (4 * (row as usize - 1) + column as usize - 1);
        (CODE >> bit) & 1 == 1
    } else if is_in(0.0, 6.0) {
        false
    } else if is_in(-1.0, 7.0) {
        true
    } else {
        return Some([0.5, 0.03, 0.03]);
    };
    Some([if is_white { 0.8 } else { 0.02 }; 3])
}

#[test]
fn place_and_yaw_are_the_objects_wherever_its_marker_lies_on_it() {
    let rig = rig();
    let tracker = Tracker::new(&rig).expect("complete");
    for (x, y, yaw) in [(0.5, 0.1, 0.0), (0.3, 0.35, 2.0), (0.75, -0.3, -1.1)] {
        let seen = tracker.observe(&draw(&rig, &[(Point::new(x, y), yaw, false)]));
        let centre = seen.centre.expect("seen");
        let off = centre.distance(Point::new(x, y));
        assert!(off < 0.0002, "{x} {y}: {off} m off");
        assert!((seen.yaw - yaw).abs() < 0.003, "{} for {yaw}", seen.yaw);
        assert!(seen.deviation > 0.5 * off && seen.deviation < 0.0005);
        let marker = seen.marker.expect("by its marker");
        assert!((marker.scale - 1.0).abs() < 0.01, "{marker:?}");
    }
}

#[test]
fn a_marker_that_is_not_read_has_a_reason_or_the_outline_tells_the_place() {
    let mut rig = rig();
    let at = Point::new(0.3, 0.35);
    let bare = draw(&rig, &[(at, 2.0, true)]);
    let both = draw(
        &rig,
        &[
            (Point::new(0.5, 0.1), 0.0, false),
            (Point::new(0.3, 0.35), 2.0, false),
        ],
    );
    let alone = Tracker::new(&rig).expect("complete");
    assert_eq!(alone.observe(&bare).centre, Err(Reason::NoMarker));
    assert_eq!(alone.observe(&both).centre, Err(Reason::TwoObjects));
    rig.object.colour = Some(Colour::demo());
    let by_outline = Tracker::new(&rig).expect("complete").observe(&bare);
    let centre = by_outline.centre.expect("its outline is seen");
    assert!(centre.distance(at) < 0.001, "{centre:?}");
    assert_eq!(by_outline.marker, None);
    // Another number lies on it.
    rig.object.colour = None;
    rig.object.marker.as_mut().expect("there").id = 1;
    let other = Tracker::new(&rig).expect("complete");
    let seen = other.observe(&draw(&rig, &[(at, 2.0, false)]));
    assert_eq!(seen.centre, Err(Reason::NoMarker));
}

#[test]
fn a_marker_that_no_dictionary_has_is_named() {
    let mut rig = rig();
    let said = |rig: &Rig| {
        let error = Tracker::new(rig).expect_err("refused");
        error.to_string()
    };
    rig.object.marker.as_mut().expect("there").id = 50;
    assert!(
        said(&rig).contains("DICT_4X4_50 has those of 0 to 49"),
        "{}",
        said(&rig)
    );
    rig.object.marker.as_mut().expect("there").dictionary = "tag36h11".into();
    assert!(said(&rig).contains("DICT_APRILTAG_36h11") || said(&rig).contains("_36h11"));
    rig.object.marker = None;
    assert!(said(&rig).contains("object.colour"));
}
