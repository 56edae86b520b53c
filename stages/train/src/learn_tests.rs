//! Choosing what is added to a world.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use stage::{ItemStage, Progress};
use values::{Command, LaunchResidual, Point, Residual, Split, split_of};

use crate::{Example, Kind, Learned, Settings, Train, TrainError, best, learn};

/// Scatter of launches: relative speed, and rad.
const SCATTER: f64 = 0.02;
/// Mean distance over the path's length that this scatter alone leaves: of a normal distribution with deviations 0.04 and 0.02.
const FLOOR: f64 = 0.037;
/// Length of every path, in m.
const DISTANCE: f64 = 0.4;

type Truth = fn(Command, &str) -> [f64; 2];

fn nothing(_: Command, _: &str) -> [f64; 2] {
    [0.0; 2]
}

/// An arm that delivers ever less, and turns with the angle.
fn arm(command: Command, _: &str) -> [f64; 2] {
    [-0.5 * (command.speed - 0.6), 0.3 * command.angle]
}

/// A camera that was turned between two days, on each of which the arm struck more to one side.
fn turned(_: Command, session: &str) -> [f64; 2] {
    [0.0, if session == "a" { 0.15 } else { -0.15 }]
}

fn strikes(count: usize, seed: u64, truth: Truth) -> Vec<Example> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, SCATTER).expect("finite");
    (0..count)
        .map(|index| {
            let is_first = index % 2 == 0;
            let angle: f64 = rng.random_range(-0.6..0.6) + if is_first { -0.4 } else { 0.4 };
            let command = Command::new(rng.random_range(0.4..1.2), angle);
            let session = if is_first { "a" } else { "b" };
            let [speed, turn] = truth(command, session).map(|truth| truth + noise.sample(&mut rng));
            let strike_id = format!("{seed}-{index}");
            let split = split_of(&strike_id, 7);
            let speed_sim = command.speed * speed.exp();
            Example {
                command,
                session: session.into(),
                distance: DISTANCE,
                split,
                is_free: true,
                launch: Some(LaunchResidual { speed, angle: turn }),
                residual: Some(Residual {
                    strike_id: strike_id.clone(),
                    path: Point::polar(DISTANCE, command.angle + turn),
                    speed_sim,
                    angle_sim: command.angle + turn,
                    d_speed: command.speed - speed_sim,
                    d_angle: -turn,
                    split,
                }),
                strike_id,
            }
        })
        .collect()
}

fn learned(examples: &[Example]) -> Learned {
    learn(examples, &Settings::default(), &|_| {}).expect("sound strikes")
}

fn score(learned: &Learned, kind: Kind) -> f64 {
    let score = learned.scores.iter().find(|score| score.kind == kind);
    score.expect("tried").by_setting / DISTANCE
}

#[test]
fn where_nothing_is_missing_nothing_is_added_or_next_to_nothing() {
    for count in [5, 10, 20, 35] {
        for seed in 0..6 {
            let learned = learned(&strikes(count, seed, nothing));
            let (none, chosen) = (score(&learned, Kind::None), score(&learned, learned.kind));
            assert!(
                chosen <= none,
                "{count} strikes, seed {seed}: {chosen} {none}"
            );
            // Chosen or not, it predicts strikes that it never saw as well as nothing does.
            let worse = unseen(&learned, nothing) / unseen_without(nothing);
            assert!(worse < 1.1, "{count} strikes, seed {seed}: {worse} times");
        }
    }
}

/// Mean share of the path by which strikes never seen are missed: with a launch map or nothing.
fn unseen(learned: &Learned, truth: Truth) -> f64 {
    let map = match &learned.model {
        Some(store::ResidualModel::Launch(map)) => Some(map),
        _ => None,
    };
    let strikes = strikes(300, 77, truth);
    let misses = strikes.iter().filter_map(|example| {
        let offset = map.map(|map| map.offset(example.command));
        let predicted = offset.map_or([0.0; 2], |offset| [offset.speed, offset.angle]);
        Some(crate::miss::Miss::of_launch(&example.launch?, predicted).share())
    });
    misses.sum::<f64>() / strikes.len() as f64
}

fn unseen_without(truth: Truth) -> f64 {
    let none = learned(&strikes(5, 0, nothing));
    assert_eq!(none.kind, Kind::None);
    unseen(&none, truth)
}

#[test]
fn what_an_arm_does_smoothly_is_learnt_from_few_strikes() {
    let errors: Vec<f64> = [10, 20, 35]
        .into_iter()
        .map(|count| {
            let learned = learned(&strikes(count, 1, arm));
            assert_eq!(learned.kind, Kind::LaunchMap, "{count}");
            let explained = learned.explained.expect("something is added");
            assert!(explained.displacement > 0.1 && explained.miss < explained.miss_p95);
            assert!((0.5..2.0).contains(&explained.calibration), "{explained:?}");
            unseen(&learned, arm)
        })
        .collect();
    let without = unseen_without(arm);
    assert!(
        errors.iter().all(|error| *error < 0.5 * without),
        "{errors:?} {without}"
    );
    assert!(errors[2] < 1.25 * FLOOR, "{errors:?}");
}

#[test]
fn with_many_strikes_networks_are_tried_and_all_three_are_listed() {
    let learned = learned(&strikes(160, 2, arm));
    let kinds: Vec<Kind> = learned.scores.iter().map(|score| score.kind).collect();
    assert_eq!(kinds, [Kind::None, Kind::LaunchMap, Kind::Networks]);
    assert!(score(&learned, Kind::Networks) < 0.5 * score(&learned, Kind::None));
    assert!(learned.kind != Kind::None && learned.training.is_some());
}

#[test]
fn a_map_that_would_mislead_in_another_session_is_not_used() {
    let learned = learned(&strikes(40, 3, turned));
    let map = learned
        .scores
        .iter()
        .find(|score| score.kind == Kind::LaunchMap);
    let map = map.expect("tried");
    let none = learned.scores[0];
    assert!(
        map.by_setting < none.by_setting,
        "within its sessions it is better"
    );
    assert!(map.by_session > none.by_session);
    assert_eq!(learned.kind, Kind::None);
}

#[test]
fn strikes_for_testing_take_no_part_and_the_same_strikes_give_the_same_answer() {
    let examples = strikes(60, 4, arm);
    let mut spoilt = examples.clone();
    let tests = spoilt
        .iter_mut()
        .filter(|example| example.split == Split::Test);
    let mut count = 0;
    for example in tests {
        example.launch = Some(LaunchResidual {
            speed: 1.0,
            angle: 1.0,
        });
        count += 1;
    }
    assert!(count > 0);
    let sets = [&examples, &spoilt];
    let both = Train::default()
        .run_items("", &sets, &Progress::hidden())
        .expect("sound strikes");
    assert_eq!(both[0], both[1]);
    assert_eq!(both[0], learned(&examples));
}

#[test]
fn strikes_without_a_launch_are_left_out_and_numbers_that_are_none_are_refused() {
    let mut examples = strikes(30, 5, arm);
    let all = learned(&examples).strikes;
    examples[3].launch = None;
    examples[4].launch = None;
    let learns = |i: usize| usize::from(examples[i].split != Split::Test);
    assert_eq!(learned(&examples).strikes, all - learns(3) - learns(4));
    let place = (5..30).find(|i| learns(*i) == 1).expect("one that learns");
    examples[place].launch = Some(LaunchResidual {
        speed: f64::NAN,
        angle: 0.0,
    });
    let error = learn(&examples, &Settings::default(), &|_| {}).expect_err("NaN");
    assert!(matches!(error, TrainError::NotFinite { .. }));
}

#[test]
fn of_two_worlds_the_one_that_misses_less_on_common_strikes_is_best() {
    let good = learned(&strikes(30, 6, nothing));
    let mut bad = good.clone();
    for (_, miss) in &mut bad.misses {
        *miss *= 2.0;
    }
    assert_eq!(best(&[&bad, &good]), Some(1));
    assert_eq!(best(&[&good, &good]), Some(0));
    // A wild miss of a strike that only one of them predicts does not count.
    let mut more = good.clone();
    more.misses.push(("another".into(), 9.0));
    assert_eq!(best(&[&more, &bad]), Some(0));
    assert_eq!(best(&[]), None);
}

/// Strikes of `arm` whose object is pushed on by half its speed where `is_pushed` says so.
fn pushed(is_pushed: impl Fn(usize, Command) -> bool) -> Vec<Example> {
    let mut examples = strikes(40, 3, arm);
    for (index, example) in examples.iter_mut().enumerate() {
        if is_pushed(index, example.command) {
            (example.is_free, example.residual) = (false, None);
            if let Some(launch) = &mut example.launch {
                launch.speed += 0.4;
            }
        }
    }
    examples
}

#[test]
fn strikes_pushed_again_teach_a_map_where_the_command_predicts_them_and_else_not() {
    let at_one = |examples: &[Example], speed: f64| match learned(examples).model {
        Some(store::ResidualModel::Launch(map)) => map.offset(Command { speed, angle: 0.0 }).speed,
        other => panic!("{other:?}"),
    };
    // Slow ones are all pushed on: the next slow one will be, too.
    let slow = at_one(&pushed(|_, command| command.speed < 0.6), 0.5);
    assert!((slow - 0.45).abs() < 0.08, "{slow}");
    // Pushed now and then, they are no strikes to learn from.
    let now_and_then = at_one(&pushed(|index, _| index % 13 == 0), 0.5);
    assert!((now_and_then - 0.05).abs() < 0.03, "{now_and_then}");
}
