//! Cameras calibrated from points that the renderer saw, and colours proposed from its pictures.

use crate::common::{Case, decoded, rig, tall};
use render::{Cover, Moment, Optics, Renderer, Scene};
use track::{
    Calibration, Decoder, KnownLens, Lens, SeenPoint, Tracker, TuneError, Tuned, Workspace,
};
use values::{Point, Rig, Shape};

#[test]
fn a_camera_calibrated_from_points_finds_the_object_where_it_is() {
    let case = Case {
        lens: true,
        ..Case::flat()
    };
    let mut rig = rig(&tall(Shape::Cylinder), &case);
    let optics = Optics::of(&rig, case.pixels).expect("complete");
    // Typed to the nearest pixel, all over the table.
    let corners = [
        [0.20, -0.28],
        [0.20, 0.32],
        [0.80, 0.32],
        [0.80, -0.28],
        [0.5, 0.0],
        [0.35, 0.2],
    ];
    let points = corners.map(|[x, y]| SeenPoint {
        at: [x, y, 0.0],
        pixel: optics.seen([x, y, 0.0]).map(f64::round),
    });
    let known = KnownLens::Lens(Lens {
        matrix: optics.matrix,
        distortion: optics.distortion,
    });
    let used = Workspace {
        table: [rig.table.x, rig.table.y],
        height: 0.02,
    };
    let found = Calibration::from_points(&points, known, used).expect("found");
    assert!(found.error < 1.0, "{found:?}");
    rig.camera.position = Some(found.position);
    rig.camera.orientation = Some(found.orientation);

    let scene = Scene::laboratory(&rig.object).expect("sizes");
    let renderer = Renderer::new(optics, scene, 2.0, 5);
    let tracker = Tracker::new(&rig).expect("complete");
    for (x, y) in [(0.3, -0.2), (0.5, 0.1), (0.7, 0.25)] {
        let rendered = renderer.render(&|_| Moment { x, y, yaw: 0.0 }, 3);
        let image = decoded(&mut Decoder::default(), None, &rendered.picture);
        let centre = tracker.observe(&image).centre.expect("found");
        let off = centre.distance(Point::new(x, y));
        // Two standard errors of the calibration, and half a millimetre of the picture.
        assert!(off < 2.0 * found.unsure + 5e-4, "{off} {found:?}");
    }
}

/// A rig whose camera has few pixels, and that camera.
fn small() -> (Rig, Optics) {
    let case = Case {
        pixels: [640, 480],
        ..Case::flat()
    };
    let rig = rig(&tall(Shape::Cylinder), &case);
    let optics = Optics::of(&rig, case.pixels).expect("complete");
    (rig, optics)
}

/// Where the object lies whose colour is proposed.
const AT: Moment = Moment {
    x: 0.4,
    y: 0.1,
    yaw: 0.0,
};

#[test]
fn a_proposed_colour_finds_the_object_in_other_light() {
    let (mut rig, optics) = small();
    let pixel = optics.seen([AT.x, AT.y, 0.04]);
    // Red, green and blue objects, on tables of other colours.
    for (object, table) in [
        ([0.50, 0.03, 0.04], [0.32, 0.31, 0.29]),
        ([0.03, 0.30, 0.06], [0.40, 0.30, 0.20]),
        ([0.03, 0.06, 0.40], [0.70, 0.70, 0.68]),
    ] {
        let mut scene = Scene::laboratory(&rig.object).expect("sizes");
        (scene.object, scene.table) = (object, table);
        let renderer = |scene: Scene| Renderer::new(optics, scene, 2.0, 4);
        let image = |renderer: &Renderer| {
            let rendered = renderer.render(&|_| AT, 1);
            decoded(&mut Decoder::default(), Some(90), &rendered.picture)
        };
        let seen = image(&renderer(scene.clone()));
        for named in [None, Some(pixel.map(|part| part as usize))] {
            let tuned = Tuned::propose(&seen, named, None).expect("proposed");
            let off = (tuned.pixel[0] - pixel[0]).hypot(tuned.pixel[1] - pixel[1]);
            assert!(off < 8.0, "{tuned:?}", tuned = tuned.pixel);
            assert!(tuned.elsewhere * 20 < tuned.area, "{}", tuned.elsewhere);
            rig.object.colour = Some(tuned.colour);
            // Half the light of the day on which it was tuned.
            let mut dim = scene.clone();
            dim.object = dim.object.map(|part| 0.5 * part);
            dim.table = dim.table.map(|part| 0.5 * part);
            let tracker = Tracker::new(&rig).expect("complete");
            for image in [&seen, &image(&renderer(dim))] {
                let centre = tracker.observe(image).centre.expect("found");
                // A pixel is 2.4 mm.
                let off = centre.distance(Point::new(AT.x, AT.y));
                println!(
                    "{object:?} {named:?}: {:.2} mm, {:?}",
                    1e3 * off,
                    tuned.colour
                );
                assert!(off < 3e-3, "{off}");
            }
        }
    }
}

#[test]
fn of_what_stands_out_the_colour_of_the_objects_size_is_proposed() {
    let (mut rig, optics) = small();
    let mut scene = Scene::laboratory(&rig.object).expect("sizes");
    // A box of another colour that stands out more, twice as wide.
    scene.covers.push(Cover {
        from: [0.6, -0.2],
        to: [0.7, -0.2],
        radius: 0.05,
        height: 0.02,
        colour: [0.0, 0.9, 0.0],
    });
    let rendered = Renderer::new(optics, scene, 2.0, 2).render(&|_| AT, 1);
    let seen = decoded(&mut Decoder::default(), None, &rendered.picture);
    let most = Tuned::propose(&seen, None, None).expect("proposed");
    rig.object.colour = Some(most.colour);
    let tracker = Tracker::new(&rig).expect("complete");
    let fits = |tuned: &Tuned| tracker.is_of_size(tuned.pixel, tuned.area as f64);
    assert!(!fits(&most), "{:?}", most.pixel);
    let object = Tuned::propose(&seen, None, Some(&fits)).expect("proposed");
    let [u, v] = optics.seen([AT.x, AT.y, 0.04]);
    let off = (object.pixel[0] - u).hypot(object.pixel[1] - v);
    assert!(off < 8.0, "{:?}", object.pixel);
}

#[test]
fn an_image_without_an_object_proposes_nothing() {
    let case = Case {
        pixels: [320, 240],
        ..Case::flat()
    };
    let rig = rig(&tall(Shape::Cylinder), &case);
    let optics = Optics::of(&rig, case.pixels).expect("complete");
    let mut scene = Scene::plain(&rig.object).expect("sizes");
    let away = Moment {
        x: 9.0,
        y: 9.0,
        yaw: 0.0,
    };
    let seen = |scene: &Scene| {
        let rendered = Renderer::new(optics, scene.clone(), 2.0, 2).render(&|_| away, 1);
        decoded(&mut Decoder::default(), None, &rendered.picture)
    };
    let bare = seen(&scene);
    assert_eq!(Tuned::propose(&bare, None, None), Err(TuneError::Nothing));
    let at_table = Tuned::propose(&bare, Some([50, 50]), None);
    assert_eq!(at_table, Err(TuneError::Table));
    assert!(matches!(
        Tuned::propose(&bare, Some([500, 50]), None),
        Err(TuneError::Outside { .. })
    ));
    // A hand as large as half of the image.
    scene.covers.push(Cover {
        from: [0.2, 0.0],
        to: [0.9, 0.0],
        radius: 0.25,
        height: 0.1,
        colour: [0.45, 0.20, 0.13],
    });
    let hand = Tuned::propose(&seen(&scene), None, None);
    assert!(matches!(hand, Err(TuneError::Size { .. })), "{hand:?}");
}
