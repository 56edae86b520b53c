//! The filter on tables whose truth is known: strikes whose distance goes as launch speed squared over friction.

use super::linear::rows;
use super::*;
use crate::{Shift, World};

/// Scatter of ln launch speed, ln distance, and bearing (rad).
const SCATTER: [f64; 3] = [0.012, 0.02, 0.006];
const SLOPES: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 1.0]];

/// Normal deviates by a linear congruential generator: the same everywhere.
struct Deviates(u64);

impl Deviates {
    fn uniform(&mut self) -> f64 {
        let next = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = next.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn strike(&mut self, shift: Shift) -> Observation {
        self.strike_within(shift, 1.0)
    }

    fn strike_within(&mut self, shift: Shift, share: f64) -> Observation {
        let away = SLOPES.map(|row| row.iter().zip(shift.values()).map(|(a, b)| a * b).sum());
        let away: [f64; 3] = away;
        Observation {
            about: Shift::default(),
            away: std::array::from_fn(|i| away[i] + share * SCATTER[i] * self.normal()),
            slopes: SLOPES,
        }
    }
}

fn world() -> World {
    World::nominal()
}

/// A hundred strikes of a version, whose friction walks by this step.
fn learnt(random: &mut Deviates, step: f64) -> Varies {
    let mut shift = Shift::default();
    let seen = (0..100).map(|order| {
        shift.friction += step * random.normal();
        (f64::from(order), random.strike(shift))
    });
    let session = Session(seen.collect());
    Varies::of(&world(), &[session])
}

fn followed(varies: &Varies, strikes: impl Iterator<Item = Observation>) -> Filter {
    let mut filter = Filter::new(varies);
    filter.begin_session();
    strikes.fold(filter, |filter, seen| filter.after(&seen, 1.0))
}

/// What a plan with this shift misses by on a table that is elsewhere, as a share of the path.
fn miss(planned: Shift, table: Shift) -> f64 {
    let distance = 2.0 * (planned.gain - table.gain) - (planned.friction - table.friction);
    distance.hypot(planned.heading - table.heading)
}

const NOON: Shift = Shift {
    friction: 0.113,
    gain: -0.051,
    heading: 0.026,
};

/// Root mean square of [`miss`] after so many strikes on a table, over forty rigs, in units of what strikes scatter by; of these strikes
/// one may be bad.
fn after(strikes: usize, table: Shift, bad: Option<usize>) -> f64 {
    let floor = SCATTER[1].hypot(SCATTER[2]);
    let squares = (0..40).map(|rig| {
        let mut random = Deviates(rig * 7919 + 1);
        let varies = learnt(&mut random, 0.0);
        let filter = followed(
            &varies,
            (0..strikes).map(|place| {
                let mut seen = random.strike(table);
                if bad == Some(place) {
                    seen.away[1] -= 0.6;
                }
                seen
            }),
        );
        (miss(filter.mean(), table) / floor).powi(2)
    });
    (squares.sum::<f64>() / 40.0).sqrt()
}

#[test]
fn a_steady_table_is_left_alone_and_a_changed_one_is_followed_from_the_first_strike() {
    for (strikes, steady, noon) in [(1, 0.3, 1.5), (3, 0.2, 1.0), (10, 0.18, 0.55)] {
        let [still, moved] = [Shift::default(), NOON].map(|table| after(strikes, table, None));
        assert!(still < steady && moved < noon, "{strikes}: {still} {moved}");
    }
    let unadapted = miss(Shift::default(), NOON) / SCATTER[1].hypot(SCATTER[2]);
    assert!(unadapted > 7.0, "{unadapted}");
}

#[test]
fn a_bad_strike_among_others_is_recognised() {
    let first = after(3, Shift::default(), Some(0));
    assert!(first < 0.6, "{first}");
    let among = after(5, NOON, Some(1));
    assert!(among < 1.2, "{among}");
}

#[test]
fn a_table_beyond_belief_is_refused_by_two_strikes_and_not_by_one() {
    let mut random = Deviates(3);
    let varies = learnt(&mut random, 0.0);
    let far = Shift {
        friction: 0.7,
        ..Shift::default()
    };
    let strikes: Vec<Observation> = (0..3).map(|_| random.strike(far)).collect();
    let check = |strikes: &[Observation]| followed(&varies, strikes.iter().copied()).check();
    assert_eq!(check(&strikes[..1]), Ok(()));
    let changed = check(&strikes).expect_err("far");
    assert!((changed.shift.friction - 0.7).abs() < 0.1, "{changed:?}");
    // No usual jump leads there: each strike alone may be a bad one, both are not.
    let turned = Shift {
        heading: 0.35,
        ..Shift::default()
    };
    let strikes: Vec<Observation> = (0..2).map(|_| random.strike(turned)).collect();
    assert_eq!(check(&strikes[..1]), Ok(()));
    assert_eq!(check(&strikes).expect_err("turned").odd, Some(2));
    for rig in 0..40 {
        let mut random = Deviates(rig * 104_729 + 5);
        let varies = learnt(&mut random, 0.0);
        for strikes in [2, 10, 60] {
            let strikes = (0..strikes).map(|_| random.strike(NOON));
            assert_eq!(followed(&varies, strikes).check(), Ok(()), "{rig}");
        }
    }
}

#[test]
fn strikes_that_fit_nothing_are_no_table_to_plan_for() {
    // Two objects by turns: no shift fits both.
    let other = Shift {
        friction: 0.4,
        ..Shift::default()
    };
    for rig in 0..20 {
        let mut random = Deviates(rig * 32_452_843 + 7);
        let varies = learnt(&mut random, 0.0);
        let strikes: Vec<Observation> = (0..10)
            .map(|place| {
                random.strike(if place % 2 == 0 {
                    Shift::default()
                } else {
                    other
                })
            })
            .collect();
        let changed = followed(&varies, strikes.into_iter()).check();
        let odd = changed.expect_err("two tables").odd;
        assert!(odd.is_some_and(|odd| odd >= 3), "{rig}: {odd:?}");
    }
}

#[test]
fn wander_is_told_from_scatter_and_is_not_seen_where_there_is_none() {
    let (mut steps, mut false_claims) = (Vec::new(), 0);
    for rig in 0..40 {
        let mut random = Deviates(rig * 15_485_863 + 11);
        steps.push(learnt(&mut random, 0.008).wander[0]);
        false_claims += usize::from(learnt(&mut random, 0.0).wander != [0.0; 3]);
    }
    let found = values::median(steps).expect("steps");
    assert!((0.004..=0.016).contains(&found), "{found}");
    assert!(false_claims <= 2, "{false_claims}");
}

#[test]
fn sessions_that_differ_widen_what_is_believed_of_the_next() {
    let mut random = Deviates(17);
    let friction = [0.05, -0.06, 0.03, -0.02, 0.06, -0.05];
    let sessions: Vec<Session> = friction
        .map(|friction| {
            let table = Shift {
                friction,
                ..Shift::default()
            };
            let seen = (0..20).map(|order| (f64::from(order), random.strike(table)));
            Session(seen.collect())
        })
        .into();
    let between = Varies::of(&world(), &sessions).between;
    assert_eq!(between.sessions, 6);
    let [friction, gain, heading] = between.deviations;
    assert!((0.03..0.08).contains(&friction), "{friction}");
    assert!(gain < 0.006 && heading < 0.004, "{gain} {heading}");
}

#[test]
fn what_six_sessions_differ_by_holds_for_a_seventh() {
    let usual = Varies::assumed(&world()).between.deviations;
    let (mut beyond, trials) = (0, 2000);
    for trial in 0..trials {
        let mut random = Deviates(trial * 7919 + 3);
        let mut session = |strikes: u32| {
            let [friction, gain, heading] = usual.map(|sd| sd * random.normal());
            let table = Shift {
                friction,
                gain,
                heading,
            };
            // Three as precise as a session of many strikes.
            let seen =
                (0..strikes).map(|order| (f64::from(order), random.strike_within(table, 0.2)));
            (table, Session(seen.collect()))
        };
        let known: Vec<(Shift, Session)> = (0..6).map(|_| session(3)).collect();
        let (seventh, _) = session(0);
        let sessions: Vec<Session> = known.iter().map(|(_, seen)| seen.clone()).collect();
        let next = Varies::of(&world(), &sessions).between.next();
        for (i, next) in next.into_iter().enumerate() {
            let mean = known
                .iter()
                .map(|(table, _)| table.values()[i])
                .sum::<f64>()
                / 6.0;
            beyond += usize::from((seventh.values()[i] - mean).abs() > 4.0 * next);
        }
    }
    // Of Student's t with nine degrees of freedom 3 in a thousand are.
    assert!(beyond as f64 <= 0.003 * 3.0 * trials as f64, "{beyond}");
}

#[test]
fn one_bad_strike_makes_no_night_look_bad_and_many_do() {
    for rig in 0..20 {
        let mut random = Deviates(rig * 7919 + 1);
        let varies = learnt(&mut random, 0.0);
        let mut scatter = |bad: usize| {
            let seen = (0..25).map(|place| {
                let mut seen = random.strike(Shift::default());
                if place < bad {
                    seen.away[1] += if place % 2 == 0 { -0.7 } else { 0.4 };
                }
                (place as f64, seen)
            });
            let seen = varies.scatter_of(&Session(seen.collect()));
            seen.expect("enough strikes").mean_square
        };
        let (one, many) = (scatter(1), scatter(12));
        assert!(one < 1.75 && many > 1.75, "{rig}: {one} {many}");
    }
}

#[test]
fn a_change_among_strikes_is_found_where_it_is_and_nowhere_else() {
    let mut off = Vec::new();
    for rig in 0..60 {
        let mut random = Deviates(rig * 104_729 + 5);
        let varies = Varies {
            wander: [0.0; 3],
            ..learnt(&mut random, 0.0)
        };
        let mut session = |changed: usize, bad: usize| {
            let seen = (0..50).map(|place| {
                let table = if place < changed {
                    Shift::default()
                } else {
                    NOON
                };
                let mut seen = random.strike(table);
                seen.away[1] -= if place == bad { 0.7 } else { 0.0 };
                (place as f64, seen)
            });
            varies.step(&Session(seen.collect()))
        };
        assert_eq!((session(50, 50), session(50, 7)), (None, None), "{rig}");
        assert_eq!(session(0, 7), None, "{rig}");
        off.push((session(37, 7).expect("a change") as f64 - 37.0).abs());
    }
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    assert!(mean < 0.5, "{mean}");
}

#[test]
fn what_varies_is_checked_where_it_is_loaded() {
    let varies = learnt(&mut Deviates(1), 0.0);
    assert_eq!(varies.check(), Ok(()));
    let mut wrong = varies.clone();
    wrong.scatter[0][1] = 1.0;
    assert!(wrong.check().is_err());
    let mut wrong = varies.clone();
    wrong.certainty = rows(&(-super::linear::Matrix::identity()));
    assert!(wrong.check().is_err());
    let mut wrong = varies;
    wrong.wander[2] = f64::NAN;
    assert!(wrong.check().is_err());
}

#[test]
fn a_strike_that_only_a_table_beyond_belief_explains_shows_nothing_until_another_says_the_same() {
    for rig in 0..40 {
        let mut random = Deviates(rig * 7919 + 1);
        let varies = learnt(&mut random, 0.0);
        let mut strikes = [(); 3].map(|()| random.strike(Shift::default()));
        strikes[0].away[1] -= 0.7;
        let first = followed(&varies, strikes[..1].iter().copied());
        assert!(!first.is_shown(), "{rig}");
        assert!(miss(first.mean(), Shift::default()) < 0.02, "{rig}");
        assert_eq!(first.if_as_it_was().mean(), Shift::default());
        let others = followed(&varies, strikes.iter().copied());
        assert!(others.is_shown(), "{rig}");
        // A new day: nothing is seen of it.
        let mut tomorrow = others.clone();
        tomorrow.begin_session();
        assert!(!tomorrow.is_shown() && tomorrow.if_as_it_was().mean() == others.mean());
    }
}

#[test]
fn the_promise_is_what_comes_of_it_after_one_strike_on_a_changed_table_and_where_the_second_is_bad()
{
    let (mut ratios, rigs) = ([0.0; 2], 100);
    for rig in 0..rigs {
        let mut random = Deviates(rig * 32_452_843 + 7);
        let varies = learnt(&mut random, 0.0);
        let mut strikes = [(); 2].map(|()| random.strike(NOON));
        strikes[1].away[1] -= 0.7;
        for (ratio, recent) in ratios.iter_mut().zip([1, 2]) {
            let filter = followed(&varies, strikes[..recent].iter().copied());
            let scatter = SCATTER[1].powi(2) + SCATTER[2].powi(2);
            let expected = miss(filter.mean(), NOON).powi(2) + scatter;
            let promised = varies.stop_scatter().powi(2) + filter.share_by_shift(&STOP_SLOPES);
            *ratio += expected / promised / f64::from(rigs as u32);
        }
    }
    let is_honest = |ratio: &f64| (0.75..1.3).contains(ratio);
    assert!(ratios.iter().all(is_honest), "{ratios:?}");
}

/// What ln distance and bearing change by with friction, gain and heading.
const STOP_SLOPES: [[f64; 3]; 2] = [SLOPES[1], SLOPES[2]];

#[test]
fn the_promise_is_what_comes_of_it_on_a_steady_table_and_on_one_that_wanders() {
    const RIGS: u64 = 100;
    for step in [0.0, 0.006] {
        let mut ratios = [0.0; 4];
        for rig in 0..RIGS {
            let mut random = Deviates(rig * 15_485_863 + 11);
            let mut tables = vec![Shift::default()];
            for place in 1..112 {
                let mut table: Shift = tables[place - 1];
                table.friction += step * random.normal();
                tables.push(table);
            }
            // The version's own table is the mean of what it learnt from.
            let mean = tables[..100].iter().map(|t| t.friction).sum::<f64>() / 100.0;
            for table in &mut tables {
                table.friction -= mean;
            }
            let strikes: Vec<Observation> = tables.iter().map(|t| random.strike(*t)).collect();
            let learnt = (0..100).map(|order| (order as f64, strikes[order]));
            let varies = Varies::of(&world(), &[Session(learnt.collect())]);
            for (ratio, recent) in ratios.iter_mut().zip([1, 2, 5, 10]) {
                let filter = followed(&varies, strikes[100..100 + recent].iter().copied());
                let expected = miss(filter.mean(), tables[100 + recent]).powi(2)
                    + SCATTER[1].powi(2)
                    + SCATTER[2].powi(2);
                let promised = varies.stop_scatter().powi(2) + filter.share_by_shift(&STOP_SLOPES);
                *ratio += expected / promised / RIGS as f64;
            }
        }
        let is_honest = |ratio: &f64| (0.8..1.2).contains(ratio);
        assert!(ratios.iter().all(is_honest), "{step}: {ratios:?}");
    }
}
