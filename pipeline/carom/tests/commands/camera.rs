//! `carom camera`: a pose from typed points, a colour from an image.

use track::{CameraModel, Image, png_of};
use values::{Rig, Shape};

use crate::fixture::{bad_input, done, folder_and_path, write};

/// The demo's rig with its camera.
fn rig() -> Rig {
    rig::film::with_camera(Rig::demo(Shape::Cylinder))
}

/// Points of the table as they are typed, with the pixels in which the rig's camera sees them.
fn typed(rig: &Rig, off: f64) -> String {
    let camera = CameraModel::of(rig).unwrap();
    let xs = [0.15, 0.55, 0.95];
    let places = xs
        .into_iter()
        .flat_map(|x| [-0.5, 0.0, 0.5].map(|y| [x, y]));
    let line = |(k, [x, y]): (usize, [f64; 2])| {
        let [u, v] = camera.pixel([x, y, 0.0]).unwrap().map(f64::round);
        let u = if k == 0 { u + off } else { u };
        format!(" --point {x},{y},{u},{v}")
    };
    places.enumerate().map(line).collect()
}

#[test]
fn a_camera_is_calibrated_from_typed_points_or_refused() {
    let (folder, dir) = folder_and_path();
    let known = rig();
    let mut open = known.clone();
    (open.camera.position, open.camera.orientation) = (None, None);
    write(&folder.path().join("rig.toml"), &open.to_toml());

    let line = format!("camera calibrate --rig {dir}/rig.toml --out {dir}/found.toml");
    let said = done(&format!("{line}{}", typed(&known, 0.0)));
    assert!(said["reprojection_error"].as_f64() < Some(1.0), "{said}");
    let found = Rig::load(&folder.path().join("found.toml")).unwrap();
    let (found, known_at) = (found.camera.position, known.camera.position);
    let (found, known_at) = (found.unwrap(), known_at.unwrap());
    for (found, known) in found.iter().zip(known_at) {
        assert!((found - known).abs() < 0.02, "{found} {known}");
    }

    let why = bad_input(&format!("{line}{}", typed(&known, 30.0)));
    assert!(why.contains("px") && why.contains("typed"), "{why}");
    let why = bad_input(&format!("{line} --point 0.2,0.1,300,200"));
    assert!(why.contains("at least 4"), "{why}");
    open.camera.matrix = None;
    write(&folder.path().join("rig.toml"), &open.to_toml());
    let why = bad_input(&format!("{line}{}", typed(&known, 0.0)));
    assert!(why.contains("--size"), "{why}");
}

/// The command lines of a page's block that contain these words.
fn commands(page: &str, words: &str) -> Vec<String> {
    let lines = page.replace("\\\n", " ");
    let of_page = lines.lines().filter(|line| line.starts_with(words));
    of_page.map(str::to_owned).collect()
}

#[test]
fn the_pages_examples_of_typed_points_are_good_calibrations() {
    let (folder, dir) = folder_and_path();
    let page = include_str!("../../docs/camera.md");
    let (_, lens) = page.split_once("```toml\n[camera]\n").unwrap();
    let (lens, _) = lens.split_once("```").unwrap();
    let rig = Rig::template();
    write(&folder.path().join("rig.toml"), rig);
    let with_lens = rig.replacen("[camera]\n", &format!("[camera]\n{lens}"), 1);
    write(&folder.path().join("lens.toml"), &with_lens);

    let examples = commands(page, "carom camera calibrate --rig");
    assert_eq!(examples.len(), 2, "{examples:?}");
    for (index, example) in examples.iter().enumerate() {
        let line = example
            .replacen("carom ", "", 1)
            .replace("--rig ", &format!("--rig {dir}/"))
            .replace("--out ", &format!("--out {dir}/{index}_"));
        let said = done(&line);
        assert!(said["reprojection_error"].as_f64() < Some(0.5), "{said}");
        assert_eq!(said["size"], serde_json::json!([640, 480]), "{example}");
    }
}

#[test]
fn a_colour_is_proposed_from_an_image_and_shown() {
    let (folder, dir) = folder_and_path();
    let (width, height) = (160, 120);
    let is_object = |at: usize| {
        let (x, y) = ((at % width) as f64, (at / width) as f64);
        (x - 90.0).hypot(y - 50.0) < 12.0
    };
    let pixel = |at: usize| {
        if is_object(at) {
            [30, 60, 190]
        } else {
            [140, 130, 120]
        }
    };
    let image = Image {
        width,
        height,
        rgb: (0..width * height).flat_map(pixel).collect(),
        grey: false,
    };
    let png = png_of(&image).unwrap();
    std::fs::write(folder.path().join("a.png"), png).unwrap();
    let said = done(&format!("camera tune {dir}/a.png --out {dir}/found.png"));
    let hue = |end: usize| said["colour"]["hue"][end].as_f64().unwrap();
    // The blue that was painted has 229 degrees.
    assert!(hue(0) < 229.0 && hue(1) > 229.0, "{said}");
    assert!(folder.path().join("found.png").is_file());
    let why = bad_input(&format!("camera tune {dir}/a.png --out {dir}/a.png"));
    assert!(why.contains("over the image"), "{why}");
    let why = bad_input(&format!(
        "camera tune {dir}/a.png --pixel 5,5 --out {dir}/b.png"
    ));
    assert!(why.contains("--pixel"), "{why}");
    write(&folder.path().join("no.png"), "no image");
    let why = bad_input(&format!("camera tune {dir}/no.png --out {dir}/b.png"));
    assert!(why.contains("neither JPEG, PNG nor WebP"), "{why}");
}

#[test]
fn a_board_that_cannot_be_is_refused_with_what_is_wrong() {
    let (folder, dir) = folder_and_path();
    write(&folder.path().join("rig.toml"), &rig().to_toml());
    let size = [320, 240];
    let image = Image {
        width: size[0],
        height: size[1],
        rgb: vec![200; 3 * size[0] * size[1]],
        grey: false,
    };
    let png = png_of(&image).unwrap();
    std::fs::write(folder.path().join("white.png"), png).unwrap();

    let line = format!("camera calibrate --rig {dir}/rig.toml");
    let board = "--square 0.04 --marker 0.03 --dictionary DICT_5X5_100";
    for (words, reason) in [
        (String::new(), "--point"),
        (
            format!("{dir}/white.png --board 5x7 {board}"),
            "--dictionary",
        ),
        (format!("{dir}/white.png --board 2x2 {board}"), "corners"),
        (format!("{dir}/white.png --board 40x40 {board}"), "markers"),
        (
            format!(
                "{dir}/white.png --board 5x7 {}",
                board.replace("0.03", "0.05")
            ),
            "smaller",
        ),
        (
            format!(
                "{dir}/white.png --board 5x7 {}",
                board.replace("5X5", "5X6")
            ),
            "7X7",
        ),
        (
            format!("--board 5x7 {board} --table {dir}/white.png --corners 0.3,0.1,0.5,0.1"),
            "corners",
        ),
    ] {
        let why = bad_input(&format!("{line} {words}"));
        assert!(why.contains(reason), "{words}: {why}");
    }
}
