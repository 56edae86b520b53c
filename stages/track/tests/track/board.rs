//! Cameras calibrated from pictures of a ChArUco board that OpenCV drew (`board.png`, by `tests/peers/markers.py`).

use crate::common::{Case, decoded, rig, tall};
use render::{Optics, Picture};
use track::{
    Board, BoardError, Calibration, Decoder, Dictionary, Image, ImageMessage, Lens, LensFit,
    Payload, SeenBoard, Workspace,
};
use values::Shape;

/// Side of a square in m, and in pixels of the drawing.
const SQUARE: f64 = 0.04;
const PIXELS: f64 = 40.0;

fn board() -> Board {
    Board {
        columns: 5,
        rows: 7,
        square: SQUARE,
        marker: 0.7 * SQUARE,
        dictionary: Dictionary::named("DICT_5X5_100").expect("known"),
    }
}

fn drawing() -> Image {
    let payload = Payload::Compressed(include_bytes!("../board.png"));
    let mut decoder = Decoder::default();
    let image = decoder.decode(&ImageMessage { stamp: 0, payload });
    image.expect("a drawing").clone()
}

/// The light of a board with white paper around it, whose upper left corner lies at a place, its rows along a direction.
fn lying(drawing: &Image, at: [f64; 2], yaw: f64) -> impl Fn([f64; 2]) -> f64 {
    let (sin, cos) = yaw.sin_cos();
    let [width, height] = [drawing.width, drawing.height].map(|size| size as f64);
    move |[x, y]| {
        let [x, y] = [x - at[0], y - at[1]];
        let [right, down] = [cos * x + sin * y, sin * x - cos * y].map(|m| m / SQUARE * PIXELS);
        let is_on = (0.0..width).contains(&right) && (0.0..height).contains(&down);
        let is_black = is_on && drawing.pixel(right as usize, down as usize)[0] < 128;
        if is_black { 0.04 } else { 0.6 }
    }
}

/// Cameras of one lens that look at the board's middle from many sides: it lies about (0.1, -0.14).
fn views() -> Vec<Optics> {
    let case = Case {
        pixels: [640, 480],
        lens: true,
        ..Case::flat()
    };
    let optics = Optics::of(&rig(&tall(Shape::Cylinder), &case), case.pixels).expect("complete");
    let sides = [
        [0.0, 0.0],
        [0.35, 0.1],
        [-0.35, 0.05],
        [0.1, 0.4],
        [-0.05, -0.4],
        [0.3, 0.3],
        [-0.3, 0.3],
        [0.3, -0.3],
        [-0.3, -0.25],
        [0.05, 0.2],
    ];
    let view = |(k, [x, y]): (usize, [f64; 2])| {
        let aside = 0.06 * (k as f64 * 1.7).sin();
        looking(
            [0.1 + x, -0.14 + y, 0.42],
            [0.1 + aside, -0.14 - aside, 0.0],
            optics,
        )
    };
    sides.into_iter().enumerate().map(view).collect()
}

/// A camera at a place that looks at another, its rows about along x.
fn looking(from: [f64; 3], to: [f64; 3], optics: Optics) -> Optics {
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|part| part * part).sum::<f64>().sqrt();
        v.map(|part| part / length)
    };
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let forward = unit([0, 1, 2].map(|i| to[i] - from[i]));
    let down = unit(cross(forward, [1.0, 0.0, 0.0]));
    let right = cross(down, forward);
    // The rotation's columns are right, down, forward; it is far from a half turn about z, so that 1 + xx - yy - zz is large.
    let x = 0.5 * (1.0 + right[0] - down[1] - forward[2]).sqrt();
    Optics {
        position: from,
        orientation: [
            x,
            0.25 * (down[0] + right[1]) / x,
            0.25 * (forward[0] + right[2]) / x,
            0.25 * (down[2] - forward[1]) / x,
        ],
        ..optics
    }
}

fn seen(optics: &Optics, light: &dyn Fn([f64; 2]) -> f64, seed: u64) -> SeenBoard {
    let picture = Picture::of_print(optics, light, 4, 2.0, seed);
    board().find(&decoded(&mut Decoder::default(), Some(92), &picture))
}

#[test]
fn a_lens_is_found_from_views_and_the_pose_from_the_board_on_the_table() {
    let (drawing, optics) = (drawing(), views());
    let light = lying(&drawing, [0.0, 0.0], 0.0);
    let mut found: Vec<SeenBoard> = Vec::new();
    let mut squares = 0.0;
    for (k, optics) in optics.iter().enumerate() {
        let seen = seen(optics, &light, k as u64);
        assert!(seen.corners.len() >= 20, "{k}: {}", seen.corners.len());
        for ([right, down], pixel) in &seen.corners {
            let there = optics.seen([*right, -down, 0.0]);
            squares += (there[0] - pixel[0]).powi(2) + (there[1] - pixel[1]).powi(2);
        }
        found.push(seen);
    }
    let corners: usize = found.iter().map(|seen| seen.corners.len()).sum();
    let rms = (squares / (2 * corners) as f64).sqrt();
    println!("{corners} corners, {rms:.3} px rms off");
    assert!(rms < 0.1, "{rms}");

    let fit = LensFit::from_views(&found, [640, 480]).expect("a lens");
    println!(
        "{fit:?}, true {:?} {:?}",
        optics[0].matrix, optics[0].distortion
    );
    assert!(fit.error < 0.15, "{fit:?}");
    for (found, known) in fit.lens.matrix.iter().zip(optics[0].matrix) {
        assert!(
            (found - known).abs() < 0.005 * optics[0].matrix[0],
            "{fit:?}"
        );
    }

    // On the table, seen by the camera that will be used.
    let case = Case {
        pixels: [1280, 720],
        lens: true,
        ..Case::flat()
    };
    let rig = rig(&tall(Shape::Cylinder), &case);
    let camera = Optics::of(&rig, case.pixels).expect("complete");
    let width = 5.0 * SQUARE;
    let mut points = Vec::new();
    for (at, yaw) in [([0.2f64, 0.45], -0.2f64), ([0.6, -0.2], 0.3)] {
        let seen = seen(&camera, &lying(&drawing, at, yaw), 99);
        let right = [at[0] + width * yaw.cos(), at[1] + width * yaw.sin()];
        let here = seen.on_table([at, right], width).expect("as wide");
        for point in &here {
            let there = camera.seen(point.at);
            let off = (there[0] - point.pixel[0]).hypot(there[1] - point.pixel[1]);
            assert!(off < 0.5, "{point:?} {there:?}");
        }
        points.extend(here);
        let wrong = seen.on_table([at, [right[0] + 0.02, right[1]]], width);
        assert!(matches!(wrong, Err(BoardError::Width { .. })), "{wrong:?}");
    }
    let lens = Lens {
        matrix: camera.matrix,
        distortion: camera.distortion,
    };
    let workspace = Workspace {
        table: [rig.table.x, rig.table.y],
        height: 0.02,
    };
    let pose = Calibration::from_board(&points, lens, workspace).expect("a pose");
    println!("{pose:?}");
    for (found, known) in pose.position.iter().zip(camera.position) {
        assert!((found - known).abs() < 0.01, "{pose:?}");
    }
}

#[test]
fn what_does_not_determine_the_lens_is_refused() {
    let (drawing, optics) = (drawing(), views());
    let light = lying(&drawing, [0.0, 0.0], 0.0);
    let one = seen(&optics[0], &light, 1);
    let few = LensFit::from_views(&[one.clone(), SeenBoard::default()], [640, 480]);
    assert!(
        matches!(few, Err(BoardError::Few { views: 1, .. })),
        "{few:?}"
    );
    // From above, again and again: any focal length does.
    let above = LensFit::from_views(&vec![one.clone(); 4], [640, 480]);
    assert!(
        matches!(
            above,
            Err(BoardError::Undetermined | BoardError::Unsure { .. })
        ),
        "{above:?}"
    );
    // Another board than the one that was said: its squares are not square.
    let mut views: Vec<SeenBoard> = optics
        .iter()
        .take(5)
        .map(|view| seen(view, &light, 2))
        .collect();
    for view in &mut views {
        for (at, _) in &mut view.corners {
            at[0] *= 1.0 + at[1];
        }
    }
    let bent = LensFit::from_views(&views, [640, 480]);
    assert!(
        matches!(
            bent,
            Err(BoardError::Poor { .. } | BoardError::Undetermined | BoardError::Unsure { .. })
        ),
        "{bent:?}"
    );

    let other = Board {
        dictionary: Dictionary::named("DICT_4X4_50").expect("known"),
        ..board()
    };
    let picture = Picture::of_print(&optics[0], &light, 2, 2.0, 1);
    let image = decoded(&mut Decoder::default(), None, &picture);
    assert!(other.find(&image).corners.is_empty());
}
