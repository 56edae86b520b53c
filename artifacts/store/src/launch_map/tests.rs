use super::*;

const CENTRE: [f64; 2] = [1.0, 0.0];
const HALF_WIDTH: [f64; 2] = [0.5, 0.4];

fn command(x: f64, y: f64) -> Command {
    Command::new(CENTRE[0] + HALF_WIDTH[0] * x, CENTRE[1] + HALF_WIDTH[1] * y)
}

/// Nothing learnt: the prior alone.
fn blank(amplitude: f64) -> Parts {
    let mut prior = vec![0.0; LINEAR];
    prior.extend(spectrum(amplitude, [1.0, 0.8]));
    let mut covariance = vec![0.0; FEATURES * FEATURES];
    for i in 0..FEATURES {
        covariance[i * FEATURES + i] = prior[i];
    }
    let map = SmoothMap {
        weights: vec![0.0; FEATURES],
        covariance,
        prior,
        scatter: 0.0,
    };
    Parts {
        centre: CENTRE,
        half_width: HALF_WIDTH,
        speed: map.clone(),
        angle: map,
    }
}

#[test]
fn features_make_a_squared_exponential_kernel() {
    let spectrum = spectrum(0.04, [1.0, 0.8]);
    let kernel = |a: [f64; 2], b: [f64; 2]| -> f64 {
        let at = |x: [f64; 2]| features(CENTRE, HALF_WIDTH, command(x[0], x[1]));
        let (a, b) = (at(a), at(b));
        (0..WAVES * WAVES)
            .map(|i| spectrum[i] * a[LINEAR + i] * b[LINEAR + i])
            .sum()
    };
    for (a, b) in [
        ([0.0, 0.0], [0.0, 0.0]),
        ([0.2, -0.3], [-0.4, 0.1]),
        ([0.5, 0.5], [-0.3, 0.2]),
    ] {
        let far = ((a[0] - b[0]) / 1.0f64).powi(2) + ((a[1] - b[1]) / 0.8f64).powi(2);
        let exact = 0.04 * (-0.5 * far).exp();
        assert!((kernel(a, b) - exact).abs() < 0.04 * 0.06, "{a:?} {b:?}");
    }
}

#[test]
fn far_from_every_strike_it_adds_nothing_and_is_as_unsure_as_before_any() {
    let mut parts = blank(0.04);
    parts.speed.weights[LINEAR + 1] = 0.3;
    let map = LaunchMap::new(parts).expect("a map");
    assert!(map.offset(command(0.1, 0.1)).speed.abs() > 1e-3);
    for far in [command(-1.8, 0.0), command(0.0, -9.0), command(0.0, 40.0)] {
        let offset = map.offset(far);
        assert_eq!(offset.speed, 0.0);
        let edge = map.offset(command(
            ((far.speed - CENTRE[0]) / HALF_WIDTH[0]).clamp(-1.0, 1.0),
            ((far.angle - CENTRE[1]) / HALF_WIDTH[1]).clamp(-1.0, 1.0),
        ));
        // Nothing was learnt at that edge either: the deviation there is the prior's.
        let apart = offset.deviation[0] - edge.deviation[0];
        assert!(
            apart.abs() < 1e-9 && edge.deviation[0] > 0.05,
            "{offset:?} {edge:?}"
        );
        assert!(map.outside(far) > 0.7);
    }
    assert_eq!(map.outside(command(1.0, -1.0)), 0.0);
}

#[test]
fn beyond_the_fastest_command_it_holds_what_was_delivered_there() {
    let mut parts = blank(0.04);
    parts.speed.weights[1] = -0.3;
    parts.angle.weights[1] = 0.1;
    let map = LaunchMap::new(parts).expect("a map");
    let slope = |commanded: Command| {
        Command::new(
            0.9 * commanded.speed,
            commanded.angle + 0.2 * commanded.speed,
        )
    };
    let (fastest, beyond) = (command(1.0, 0.3), command(2.0, 0.3));
    let there = map.deliver(fastest, &slope);
    assert_eq!(map.deliver(beyond, &slope), there);
    assert!((there.speed - 0.9 * 1.5 * (-0.3f64).exp()).abs() < 1e-12);
    let (near, far) = (map.offset(fastest).deviation, map.offset(beyond).deviation);
    let added = (far[0].powi(2) - near[0].powi(2)).sqrt();
    assert!((added - (2.0f64 / 1.5).ln()).abs() < 1e-9 && far[1] == near[1]);
    // Slower ones go on in proportion.
    let slow = command(-1.5, 0.3);
    assert!(map.deliver(slow, &slope).speed < there.speed);
}

#[test]
fn whatever_its_weights_it_is_bounded() {
    let mut parts = blank(0.04);
    parts.speed.weights[0] = 1e6;
    parts.angle.weights[1] = -1e6;
    let map = LaunchMap::new(parts).expect("finite");
    let delivered = map.deliver(command(0.5, 0.0), &|_| command(0.0, 0.0));
    assert!(delivered.speed <= 4.0 * 1.0 + 1e-9 && delivered.angle >= -1.0);
}

#[test]
fn numbers_that_are_no_map_are_refused() {
    type Spoil = fn(&mut Parts);
    let spoils: [Spoil; 7] = [
        |parts| parts.centre[0] = f64::NAN,
        |parts| parts.half_width[1] = 0.0,
        |parts| parts.centre[0] = -parts.half_width[0],
        |parts| parts.speed.weights[3] = f64::INFINITY,
        |parts| {
            parts.angle.covariance.pop();
        },
        |parts| parts.angle.scatter = -1.0,
        |parts| parts.speed.prior[0] = f64::NAN,
    ];
    for (index, spoil) in spoils.iter().enumerate() {
        let mut parts = blank(0.01);
        spoil(&mut parts);
        assert!(LaunchMap::new(parts).is_err(), "{index}");
    }
}
