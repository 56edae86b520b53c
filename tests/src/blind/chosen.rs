//! Strikes needed to separate a pair: those that the diagnosis proposes, against more of the same.
//!
//! Strikes are added to a set whose diagnosis leaves the hidden effect and others standing, once as `next_strikes` says and once
//! at random, and it is diagnosed again each time: until the hidden effect is named, and T, twice the logarithm of the odds,
//! exceeds 10.8 against that other (95 %: Φ(√T/2)).

use diagnose::{Diagnose, Diagnosis, Input};
use rig::{PlannedStrike, Truth};
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Rig, Split, Strike};
use world::World;

use super::cases::{Case, Kind};
use super::hide;
use super::outcome::believed_friction;
use super::set::{Made, Make, identified, strikes};

/// Numbers of strikes after which it is diagnosed again: the same for chosen and for random ones, of which more are made.
const LOOKS: [usize; 9] = [1, 2, 4, 8, 12, 24, 48, 96, 192];
const MOST_CHOSEN: usize = 48;
const MOST_RANDOM: usize = LOOKS[LOOKS.len() - 1];
/// Number of chosen strikes made at a time.
const AT_A_TIME: usize = 12;

/// Strikes that a set begins with, and what is hidden in it: effects of the table and the camera, which strikes elsewhere, faster
/// or at another angle can separate.
const FEW: usize = 20;
/// Number of sets for each seed of the benchmark: most leave nothing to separate.
const SETS: u64 = 3;
const STARTS: [&str; 6] = [
    "speed_weakening_friction",
    "anisotropic_friction",
    "friction_patch",
    "table_tilt",
    "table_bowl",
    "camera_distortion",
];
/// Odds in log-likelihood at which a pair is separated: half of T.
const TOLD_APART: f64 = 5.4;

/// A set to which strikes were added, both ways.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Separation {
    pub id: String,
    /// What stood beside the hidden effect; empty where the first diagnosis left nothing to separate.
    pub pairs: Vec<Pair>,
}

/// Number of strikes that separated a pair.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pair {
    pub hidden: String,
    pub rival: String,
    /// Strikes that were needed; none where those made were not enough.
    pub chosen: Option<usize>,
    /// Random strikes that were needed; none where those made were not enough.
    pub random: Option<usize>,
}

impl Pair {
    /// Random strikes for each chosen one, at the least; none where neither separated it. Where chosen ones did not, they count as of
    /// no use.
    pub fn times(&self) -> Option<f64> {
        match (self.chosen, self.random) {
            (None, None) => None,
            (None, Some(_)) => Some(0.0),
            (Some(chosen), random) => Some(random.unwrap_or(MOST_RANDOM) as f64 / chosen as f64),
        }
    }
}

/// Sets to which strikes are added: few strikes of weak effects that stand for one another while strikes are few.
pub fn starts(seeds: u64, first: u64) -> Vec<Case> {
    let mut all = Vec::new();
    for effect in STARTS {
        for magnitude in [0.5, 1.0] {
            for _ in 0..SETS * seeds {
                let seed = first + 5_000 + all.len() as u64;
                all.push(Case {
                    id: format!("{effect}-x{magnitude}-n{FEW}-s{seed}"),
                    kind: Kind::Single,
                    hidden: vec![effect.to_string()],
                    magnitude,
                    strikes: FEW,
                    seed,
                    variant: "plain".into(),
                });
            }
        }
    }
    all
}

struct Start {
    truth: Truth,
    rig: Rig,
    world: World,
    base: Vec<Strike>,
    name: String,
}

impl Start {
    fn diagnose(&self, more: &[Strike], next_strikes: usize) -> Option<Diagnosis> {
        let strikes: Vec<Strike> = self.base.iter().chain(more).cloned().collect();
        let settings = Diagnose {
            most_strikes: strikes.len(),
            next_strikes,
            ..Diagnose::default()
        };
        let input = Input::of(self.rig.clone(), self.world.clone(), strikes);
        let found = settings.run(&input, &Progress::hidden()).ok()?;
        Some(found.diagnosis)
    }

    /// Others that odds do not exclude in the place of the hidden effect; none where it does not stand itself.
    fn rivals(&self, diagnosis: &Diagnosis) -> Option<Vec<String>> {
        let [effect] = diagnosis.effects.as_slice() else {
            return None;
        };
        let best = &effect.name;
        let all = effect.rivals.iter().map(|r| (&r.name, r.evidence));
        let all: Vec<_> = [(best, effect.evidence)].into_iter().chain(all).collect();
        let (_, hidden) = all.iter().find(|(name, _)| **name == self.name)?;
        let others = all
            .iter()
            .filter(|(name, evidence)| **name != self.name && *evidence > hidden - TOLD_APART);
        Some(others.map(|(name, _)| name.to_string()).collect())
    }

    /// Notes at how many strikes each rival is gone, and whether all are.
    fn note(
        &self,
        separated_at: &mut [Option<usize>],
        among: &[String],
        found: &Diagnosis,
        at: usize,
    ) -> bool {
        let left = self.rivals(found);
        for (first, rival) in separated_at.iter_mut().zip(among) {
            // Distinguished at one look and not at the next was luck.
            let is_gone = left.as_ref().is_some_and(|left| !left.contains(rival));
            *first = first.filter(|_| is_gone).or(is_gone.then_some(at));
        }
        separated_at.iter().all(Option::is_some)
    }

    /// Strikes of a plan, or at random, in the rig as it is; none of them judges.
    fn strike(
        &self,
        plan: Option<Vec<PlannedStrike>>,
        count: usize,
        round: u64,
    ) -> Option<Vec<Strike>> {
        let mut truth = self.truth.clone();
        truth.seed += 1_000_000 * (1 + round);
        let folder = tempfile::tempdir().ok()?;
        let make = Make {
            plan,
            ..Make::random(&truth, count)
        };
        let mut made = strikes(make, folder.path())?.strikes;
        for (i, strike) in made.iter_mut().enumerate() {
            strike.id = format!("{round}-{i:04}");
            strike.split = Split::Train;
            strike.conditions = self.base.last()?.conditions.clone();
        }
        Some(made)
    }

    fn at_random(&self, among: &[String]) -> Option<Vec<Option<usize>>> {
        let all = self.strike(None, MOST_RANDOM, 0)?;
        let mut separated_at = vec![None; among.len()];
        for look in LOOKS {
            let found = self.diagnose(&all[..look.min(all.len())], 0)?;
            if self.note(&mut separated_at, among, &found, look) {
                break;
            }
        }
        Some(separated_at)
    }

    fn as_asked(&self, among: &[String], first: &Diagnosis) -> Option<Vec<Option<usize>>> {
        let mut asked = first.next_strikes.clone();
        let mut made: Vec<Strike> = Vec::new();
        let mut separated_at = vec![None; among.len()];
        while !asked.is_empty() && made.len() < MOST_CHOSEN {
            let plan: Vec<PlannedStrike> = asked
                .iter()
                .map(|next| PlannedStrike {
                    x0: next.x0,
                    y0: next.y0,
                    speed: next.speed,
                    angle: next.angle,
                })
                .collect();
            let before = made.len();
            made.extend(self.strike(Some(plan), asked.len(), 1 + before as u64)?);
            for look in LOOKS
                .into_iter()
                .filter(|look| (before + 1..=made.len()).contains(look))
            {
                let found = self.diagnose(&made[..look], AT_A_TIME)?;
                if self.note(&mut separated_at, among, &found, look) {
                    return Some(separated_at);
                }
                asked = found.next_strikes;
            }
            if !LOOKS.contains(&made.len()) {
                // Between looks it only makes more.
                asked = self.diagnose(&made, AT_A_TIME)?.next_strikes;
            }
        }
        Some(separated_at)
    }
}

/// Adds strikes to a case until its pairs are separated, both ways.
pub fn separate(case: &Case) -> Separation {
    Separation {
        id: case.id.clone(),
        pairs: separated(case).unwrap_or_default(),
    }
}

fn separated(case: &Case) -> Option<Vec<Pair>> {
    let folder = tempfile::tempdir().ok()?;
    let truth = hide::truth(case)?;
    let make = Make::random(&truth, case.strikes);
    let Made {
        rig, strikes: base, ..
    } = strikes(make, folder.path())?;
    let world = identified(&rig, &base, believed_friction(case, truth.friction)).ok()?;
    let start = Start {
        truth,
        rig,
        world,
        base,
        name: case.hidden.first()?.clone(),
    };
    let first = start.diagnose(&[], AT_A_TIME)?;
    let among = start.rivals(&first)?;
    if among.is_empty() {
        return None;
    }
    let chosen = start.as_asked(&among, &first)?;
    let random = start.at_random(&among)?;
    let each = among.into_iter().zip(chosen.into_iter().zip(random));
    Some(
        each.map(|(rival, (chosen, random))| Pair {
            hidden: start.name.clone(),
            rival,
            chosen,
            random,
        })
        .collect(),
    )
}
