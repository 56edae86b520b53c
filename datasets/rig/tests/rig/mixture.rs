//! What the demo's hidden mixture leaves to plain system identification, and to a residual that knows the path alone.
//!
//! The plain model here is the rig's own physics with nothing hidden, its friction and one factor of launch fitted to whole
//! tracks: the best that a simulator with the right geometry could do.

use nalgebra::{DMatrix, DVector};
use rig::demo::{Settings, write};
use rig::{Hidden, Sim, StrikeIndex, StrikeTruth, Truth};
use values::{Command, Point, Shape};

/// Camera frames of each track that the fit uses.
const FRAMES: u32 = 60;
/// Degree of the polynomial that stands in for the residual network.
const DEGREE: i32 = 5;

struct Plain {
    friction: f64,
    factor: f64,
}

impl Plain {
    fn truth(&self, of: &Truth) -> Truth {
        let hidden = Hidden::parse(&[format!("striker_speed_error=0,{},100,0", self.factor)])
            .expect("valid");
        Truth {
            hidden,
            friction: self.friction,
            ..of.clone()
        }
    }

    /// Gauss–Newton on friction and factor over every twelfth strike's track.
    fn fit(of: &Truth, strikes: &[StrikeTruth]) -> Self {
        let few: Vec<_> = strikes.iter().step_by(12).collect();
        let tracks = |model: &Truth| {
            let track = |strike: &&StrikeTruth| {
                let outcome = model
                    .outcome(
                        of.see(strike.initial, strike.index()),
                        strike.command,
                        StrikeIndex::default(),
                    )
                    .expect("a demo rig");
                let seen = |frame| model.see(outcome.at(f64::from(frame) / 60.0), strike.index());
                (1..=FRAMES)
                    .flat_map(move |frame| <[f64; 2]>::from(seen(frame)))
                    .collect::<Vec<_>>()
            };
            DVector::from_vec(few.iter().flat_map(track).collect())
        };
        let measured = tracks(of);
        let mut plain = Self {
            friction: 0.2,
            factor: 1.0,
        };
        for _ in 0..8 {
            let at = |friction, factor| tracks(&Self { friction, factor }.truth(of));
            let now = at(plain.friction, plain.factor);
            let by_friction = (at(plain.friction + 0.005, plain.factor) - &now) / 0.005;
            let by_factor = (at(plain.friction, plain.factor + 0.01) - &now) / 0.01;
            let step = least_squares(
                DMatrix::from_columns(&[by_friction, by_factor]),
                &measured - now,
            );
            plain.friction = (plain.friction + step[0]).clamp(0.05, 0.8);
            plain.factor = (plain.factor + step[1]).clamp(0.3, 2.0);
        }
        plain
    }
}

fn least_squares(matrix: DMatrix<f64>, right: DVector<f64>) -> DVector<f64> {
    matrix
        .svd(true, true)
        .solve(&right, 1e-12)
        .expect("both factors were asked for")
}

/// The command for which a model's object goes from one point to another; range goes as speed squared.
fn solve(model: &Truth, from: Point, to: Point) -> Command {
    let path = to - from;
    let mut command = Command::new(0.6, path.bearing());
    for _ in 0..60 {
        let reached = model
            .outcome(from, command, StrikeIndex::default())
            .expect("a demo rig")
            .stop()
            - from;
        if reached.distance(path) < 1e-4 {
            break;
        }
        command.speed *= (path.norm() / reached.norm()).sqrt();
        command.angle += 0.6 * (path.bearing() - reached.bearing());
    }
    command
}

fn features(path: Point) -> Vec<f64> {
    let (range, bearing) = (1.5 * path.norm().sqrt() - 0.8, 1.5 * path.bearing());
    (0..=DEGREE)
        .flat_map(|i| (0..=DEGREE - i).map(move |j| range.powi(i) * bearing.powi(j)))
        .collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn check(shape: Shape) {
    let folder = tempfile::tempdir().expect("a folder");
    let written = write(&Settings::new(shape, 500, 1, None), folder.path()).expect("a demo");
    let truth = Truth::load(&written.truth).expect("its truth");
    let plain = Plain::fit(&truth, &truth.strikes).truth(&truth);
    let rows: Vec<(Point, Point, Command, Command)> = truth
        .strikes
        .iter()
        .map(|strike| {
            (
                truth.see(strike.initial, strike.index()),
                truth.see(strike.stop, strike.index()),
                strike.command,
            )
        })
        .map(|(from, to, command)| (from, to, command, solve(&plain, from, to)))
        .collect();
    let (train, test) = rows.split_at(400);
    let inputs: Vec<f64> = train
        .iter()
        .flat_map(|row| features(row.1 - row.0))
        .collect();
    let inputs = DMatrix::from_row_slice(train.len(), inputs.len() / train.len(), &inputs);
    let learn = |of: fn(&Command) -> f64| {
        let delta = train.iter().map(|row| of(&row.2) - of(&row.3)).collect();
        least_squares(inputs.clone(), DVector::from_vec(delta))
    };
    let (speed, angle) = (learn(|c| c.speed), learn(|c| c.angle));

    let mut robot = Sim::from(Truth {
        seed: 99,
        ..truth.clone()
    })
    .expect("a demo rig");
    let mut miss = |from, to, command| robot.strike(from, command).stop.distance(to);
    let sysid = mean(
        test.iter()
            .map(|&(from, to, _, solved)| miss(from, to, solved)),
    );
    let residual = mean(test.iter().map(|&(from, to, _, solved)| {
        let inputs = DVector::from_vec(features(to - from));
        miss(
            from,
            to,
            Command::new(
                solved.speed + speed.dot(&inputs),
                solved.angle + angle.dot(&inputs),
            ),
        )
    }));
    let floor = mean(test.iter().map(|&(from, _, command, _)| {
        let expected = truth
            .expected_stop(from, command, StrikeIndex::default())
            .expect("a demo rig");
        miss(from, expected, command)
    }));
    println!(
        "{shape:?}: sysid {sysid:.4} m, with a residual {residual:.4} m, repeats {floor:.4} m"
    );
    assert!(
        (0.05..0.09).contains(&sysid),
        "{shape:?}: plain sysid misses by {sysid} m"
    );
    assert!(
        (0.003..0.008).contains(&floor),
        "{shape:?}: repeats scatter by {floor} m"
    );
    assert!(
        residual < 0.13 * sysid,
        "{shape:?}: the residual could reach {residual} m of {sysid} m"
    );
}

#[test]
fn the_demo_leaves_plain_sysid_centimetres_that_the_path_alone_explains_for_a_cylinder() {
    check(Shape::Cylinder);
}

#[test]
fn the_demo_leaves_plain_sysid_centimetres_that_the_path_alone_explains_for_a_box() {
    check(Shape::Box);
}
