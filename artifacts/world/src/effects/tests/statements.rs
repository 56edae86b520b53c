//! The sentences that state fitted values.

use crate::AddedEffect;

/// Effects with the values of their parameters, and below each its sentence.
const STATED: &str = "\
viscous_drag: rate = 0.3
    drag grows with speed: 0.30 m/s² for every m/s of speed
quadratic_drag: coefficient = 0.21
    drag grows with the square of the speed: 0.21 m/s² at 1 m/s
speed_weakening_friction: rise = 0.25, speed = 0.3
    friction is 25 % higher near rest than at speed; half of that is gone at 0.25 m/s
anisotropic_friction: contrast = -0.1, direction = 0.5
    friction across the grain exceeds that along it by 10 % of their mean; the grain runs at -61° from +x
friction_patch: center_x = 0.5, center_y = 0.04, radius = 0.09, change = 0.32
    friction is 32 % higher inside a disc of 9.0 cm radius around (0.50, 0.04) m
friction_drift: rate = -0.08
    friction falls by 8.0 % of its first value every 100 strikes
friction_by_session: monday.mcap = 0.12, tuesday.mcap = -0.05
    friction is 8.2 % higher in monday.mcap, 8.2 % lower in tuesday.mcap than in their mean
table_tilt: tilt_x = 0.0, tilt_y = 0.005
    the table slopes down by 5.0 mm per metre towards 90° from +x
table_bowl: curvature = 0.03, center_x = 0.4, center_y = 0.1
    the table is hollow (a spring or a cable pulls alike): it pulls towards (0.40, 0.10) m with 0.29 m/s² for every metre from there
striker_speed_error: offset = -0.02, slope = 0.95, cap = 0.85
    the arm delivers 0.95 times the commanded speed less 0.020 m/s, and at most 0.85 m/s
striker_angle_bias: bias = -0.02
    the arm strikes 1.1° to the right of the commanded direction
speed_dependent_restitution: slope = 0.2
    restitution falls with impact speed: by 20 % of its value at 0.7 m/s for every m/s
off_centre_contact: offset = 0.0012
    the tip passes 1.2 mm to the left of the object's centre
friction_drift: rate = 0.5, saturation = 2.0
    friction rises by 25 % in all, two thirds of that within 55 strikes
friction_drift: rate = 0.42, saturation = 0.3
    friction rises by 36 % within the first 100 strikes, and ever more slowly
friction_drift: rate = 0.2, saturation = 1.0, shape = 8.0
    friction rises by 20 % between strikes 75 and 111
friction_drift: rate = 0.004, saturation = 0.02, shape = 8.0
    friction rises by 20 % between strikes 3774 and 5549
restitution_drift: rate = -0.1, saturation = 2.0, shape = 90.0
    restitution falls by 5.0 % at strike 50; an arm whose speed changes, or an object of another mass, shows the same
striker_angle_error: gain = 0.64, slope = -0.1
    the arm strikes at 1.64 times the commanded angle, 5.7° to the right for every m/s of speed
striker_angle_error: bias = 0.5, slope = -0.4
    the arm strikes at the commanded angle, 28.6° to the left less 22.9° for every m/s of speed
striker_angle_by_session: monday.mcap = 0.02, tuesday.mcap = -0.01
    objects leave 1.1° to the left in monday.mcap, 0.6° to the right in tuesday.mcap of the commanded direction
restitution_drift: rate = -0.1
    restitution falls by 10 % of its first value every 100 strikes; an arm whose speed changes, or an object of another mass, shows the same
friction_gradient: gradient_y = 0.25
    friction rises by 25 % per metre towards 90° from +x
striker_error_by_place: speed_x = -0.3, angle_y = 0.2, bias = 0.02
    the arm delivers 30 % more speed for each metre that the object lies towards 180° from +x, and strikes 11.5° further left for each metre that the object lies towards 90° from +x, and strikes 1.1° to the left in the middle of the starts
friction_step: offset = 0.5, change = -0.2
    friction is 20 % lower beyond the line through (0.50, 0.00) m, towards 0° from +x
friction_map: node_11 = 0.2, node_30 = -0.1
    friction varies over the table: 20 % higher around (0.32, 0.10) m, 10 % lower around (0.68, -0.10) m
friction_line: center_y = 0.1, offset = -0.1, length = 0.05
    a line lies across the table through (0.40, 0.10) m, towards 90° from +x, 6.0 cm wide: a crossing costs as much as 5.0 cm of way more, as glue, tape, a scratch or a smooth strip would do; look at the table there, and log again once it is clean
local_pull: center_y = -0.05, pull = 8.0
    something pulls objects towards (0.50, -0.05) m, by up to 0.21 m/s² some 4 cm from there, as a magnet below the table or a single dent does: look there, and log again without it
local_push: center_y = -0.05, push_x = 0.3, push_y = 0.4
    something pushes objects towards 53° from +x, by 0.50 m/s² at (0.50, -0.05) m and less from some 10 cm on, as air that blows there or a plate that slopes does: look there, and log again without it
path_curl: part = -0.12
    paths curl to the right, by a force across the way of 12 % of friction's: an object that spins or stands on one edge does so; look at its base, and at whether the tip strikes its middle
path_curl: part = -0.12, rate = 0.4
    paths curl to the right, by a force across the way of 12 % of friction's, less 0.40 m/s² for every m/s of speed: an object that spins or stands on one edge does so; look at its base, and at whether the tip strikes its middle
air_whirl: rate = 0.8, center_y = 0.1
    something pushes objects round about (0.50, 0.10) m, to the left, by 0.80 m/s² for every metre from there, as air that turns does and no table: look for a fan or an outlet of air, and log again without it
camera_stretch: diagonal = 0.01
    the camera shows lengths 2.0 % longer towards 45° from +x than across it: its calibration is not that of this table (a homography of other points, pixels that are not square, a readout that is not stated); calibrate it again, and measure a known length both ways
camera_seam: offset = -0.1, shift_x = 0.003, shift_y = 0.003
    beyond a line through (0.40, 0.00) m, across 0° from +x, objects are seen shifted by 4.2 mm towards 45°: two cameras or two calibrations do not agree there, or a border of light or print pulls the tracker; look at images of the line, and calibrate again
friction_from_start: change = 0.5, length = 0.02
    friction is 50 % higher where a slide begins, and as elsewhere after some 40 mm, wherever objects are struck: an object that sticks while it lies, is lifted by the tip, or slides on a film at first does so; look at its base, at the height at which the tip strikes, and at how long it lies before
table_tilt_by_session: a.mcap = 0.003, b.mcap tilt_y = 0.004
    the table slopes down otherwise in each session: by 3.0 mm per metre towards 0° from +x in a.mcap, by 4.0 mm per metre towards 90° from +x in b.mcap; it was moved or levelled between them, or a draught came from elsewhere: level it, fix it, and log again
camera_lean: lean_x = 0.035
    the camera leans: it shows lengths 3.5 % smaller for every metre towards 0° from +x
striker_speed_error: cap = 1.48, softness = 0.4
    but for a constant factor that restitution holds, the arm delivers the commanded speed, but ever less than that as it comes near 1.48 m/s
camera_rotation: angle = 0.01
    the camera sees the table turned by 0.57° to the left about its centre
camera_distortion: k1 = -0.08
    the lens shows what is 0.5 m from its axis at (0.45, 0.00) m 2.0 % too near to it
";

#[test]
fn fitted_values_are_stated_in_a_sentence() {
    let lines: Vec<&str> = STATED.lines().collect();
    for case in lines.chunks(2) {
        let stated = AddedEffect::listed(case[0]).to_string();
        assert_eq!(stated, case[1].trim_start());
    }
}
