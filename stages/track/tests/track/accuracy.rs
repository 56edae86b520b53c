//! Centres from rendered pictures against where the object was rendered.

use crate::common::{Case, Errors, rig, tall};
use render::Scene;
use render::case::{disc, gradient, shadow};
use values::Shape;

#[test]
fn a_flat_disc_is_found_to_a_few_hundredths_of_a_pixel() {
    let plain = Case::flat();
    let light = Case {
        scene: gradient,
        ..Case::flat()
    };
    let shade = Case {
        scene: shadow,
        ..Case::flat()
    };
    let blur = Case {
        speed: 1.0,
        exposure: 0.005,
        ..Case::flat()
    };
    for (name, case) in [
        (
            "clean",
            Case {
                noise: 0.0,
                ..plain
            },
        ),
        ("noise", plain),
        ("light", light),
        ("shadow", shade),
        ("blur", blur),
    ] {
        let errors = Errors::of(&case, &disc(), 12);
        println!("{name}: {errors}");
        assert_eq!(errors.lost, 0, "{name}: {errors}");
        assert!(errors.rms_px < 0.03, "{name}: {errors}");
    }
}

#[test]
fn everything_at_once_on_a_flat_disc() {
    let errors = Errors::of(&Case::all(), &disc(), 40);
    println!("all, flat: {errors}");
    assert_eq!(errors.lost, 0, "{errors}");
    assert!(errors.rms_px < 0.08, "{errors}");
}

#[test]
fn the_centre_of_a_tall_object_on_the_table() {
    // 1.2 and 2.4 mm a pixel.
    for (pixels, rms, worst) in [([1280, 720], 0.5, 1.0), ([640, 480], 1.0, 2.5)] {
        for shape in [Shape::Cylinder, Shape::Box, Shape::Sphere] {
            let case = Case {
                pixels,
                ..Case::all()
            };
            let errors = Errors::of(&case, &tall(shape), 12);
            println!("all, {} {pixels:?}: {errors}", shape.name());
            assert_eq!(errors.lost, 0, "{errors}");
            assert!(errors.rms_mm < rms && errors.worst_mm < worst, "{errors}");
        }
    }
}

#[test]
fn the_scene_of_a_rig_is_complete() {
    assert!(Scene::laboratory(&rig(&disc(), &Case::all()).object).is_some());
}
