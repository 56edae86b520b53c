//! A network that learns a residual that is known.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use values::{Point, Residual, split_of};
use world::GRAVITY;

use crate::{Settings, TrainError, Trained, fit};

/// Deviation of the labels' noise, in m/s and rad.
const NOISE: f64 = 0.005;
/// The mean absolute error that this noise alone leaves.
const FLOOR: f64 = NOISE * 0.797_884_56;

/// What hides in the synthetic rows.
fn truth(speed: f64, angle: f64) -> [f64; 2] {
    [
        0.06 * speed + 0.05 * speed * speed,
        0.04 + 0.02 * (4.0 * angle + 3.0 * speed).sin(),
    ]
}

/// Strikes on a table with friction 0.3 and a launch factor of 1.5, a tenth of them for testing.
pub(crate) fn synthetic(count: usize, seed: u64) -> Vec<Residual> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, NOISE).expect("finite");
    (0..count)
        .map(|index| {
            let speed = rng.random_range(0.4..1.0);
            let angle = rng.random_range(-0.6..0.6);
            let distance = (1.5f64 * speed).powi(2) / (2.0 * 0.3 * GRAVITY);
            let [d_speed, d_angle] =
                truth(speed, angle).map(|value| value + noise.sample(&mut rng));
            let strike_id = format!("{seed}-{index}");
            Residual {
                split: split_of(&strike_id, 7),
                strike_id,
                path: Point::polar(distance, angle),
                speed_sim: speed,
                angle_sim: angle,
                d_speed,
                d_angle,
            }
        })
        .collect()
}

fn train(rows: &[Residual], settings: &Settings) -> Trained {
    fit(rows, settings, &mut |_| {}).expect("enough rows")
}

/// Error against the truth without noise, on a grid of the strikes' region.
fn truth_error(trained: &Trained) -> f64 {
    let rows = synthetic(2_000, 99);
    let error = |row: &Residual| {
        let inputs = [row.path.x, row.path.y, row.speed_sim, row.angle_sim];
        let (predicted, truth) = (
            trained.network.predict(inputs),
            truth(row.speed_sim, row.angle_sim),
        );
        0.5 * ((predicted[0] - truth[0]).abs() + (predicted[1] - truth[1]).abs())
    };
    rows.iter().map(error).sum::<f64>() / rows.len() as f64
}

#[test]
fn five_hundred_rows_are_learnt_to_their_noise() {
    let trained = train(&synthetic(500, 1), &Settings::default());
    let test = trained.test.expect("a tenth");
    assert!(test.raw < 1.25 * FLOOR, "{test:?}");
    assert!(
        truth_error(&trained) < 0.5 * FLOOR,
        "{}",
        truth_error(&trained)
    );
    assert!(
        trained.validation.raw < 0.015,
        "the paper's validation error"
    );
}

#[test]
fn the_same_rows_and_seed_give_the_same_bytes_and_another_seed_others() {
    let rows = synthetic(120, 2);
    let settings = Settings {
        epochs: 12,
        ..Settings::default()
    };
    let first = train(&rows, &settings);
    // Trainings beside each other share burn's process-wide state; none of it may reach the weights.
    let beside: Vec<Trained> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..3)
            .map(|_| scope.spawn(|| train(&rows, &settings)))
            .collect();
        runs.into_iter()
            .map(|run| run.join().expect("no panic"))
            .collect()
    });
    for other in &beside {
        assert_eq!(
            store::ResidualModel::from(other.network.clone()).to_safetensors(),
            store::ResidualModel::from(first.network.clone()).to_safetensors()
        );
        assert_eq!(other.history, first.history);
    }
    let another = train(
        &rows,
        &Settings {
            seed: 1,
            ..settings
        },
    );
    assert_ne!(another.network, first.network);
}

#[test]
fn test_rows_take_no_part() {
    let mut rows = synthetic(120, 3);
    let settings = Settings {
        epochs: 6,
        ..Settings::default()
    };
    let before = train(&rows, &settings);
    for row in rows
        .iter_mut()
        .filter(|row| row.split == values::Split::Test)
    {
        row.d_speed += 1.0;
    }
    let after = train(&rows, &settings);
    assert_eq!(before.network, after.network);
    let rise = after.test.expect("some").d_speed - before.test.expect("some").d_speed;
    assert!(rise > 0.9, "they are measured all the same: {rise}");
}

#[test]
fn training_stops_early_and_keeps_the_best_weights() {
    let trained = train(&synthetic(200, 4), &Settings::default());
    let best = trained
        .history
        .iter()
        .min_by(|a, b| a.validation_mae.total_cmp(&b.validation_mae))
        .expect("epochs");
    assert_eq!(best.epoch, trained.best_epoch);
    // Followed in burn, measured by the folded network.
    let differs = best.validation_mae / trained.validation.scaled - 1.0;
    assert!(differs.abs() < 1e-4, "{differs}");
    assert!(
        trained.history.len() < 500,
        "it went on for {} epochs",
        trained.history.len()
    );
    assert_eq!(trained.history.len(), trained.best_epoch + 20);
    assert!(trained.history.last().expect("epochs").rate < 1e-3);
}

#[test]
fn more_strikes_make_a_better_network() {
    let rows = synthetic(500, 5);
    let errors =
        [25, 100, 500].map(|count| truth_error(&train(&rows[..count], &Settings::default())));
    assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
}

#[test]
fn too_few_rows_and_bad_rows_are_reported() {
    let rows = synthetic(8, 6);
    let none = fit(&rows, &Settings::default(), &mut |_| {});
    assert!(matches!(none, Err(TrainError::TooFewRows { .. })));
    let mut rows = synthetic(60, 6);
    rows[17].d_angle = f64::NAN;
    let error = fit(&rows, &Settings::default(), &mut |_| {})
        .expect_err("NaN")
        .to_string();
    assert!(error.contains("6-17"), "{error}");
    let settings = Settings {
        batch: 1,
        ..Settings::default()
    };
    assert!(matches!(
        fit(&rows, &settings, &mut |_| {}),
        Err(TrainError::Setting { name: "batch", .. })
    ));
}
