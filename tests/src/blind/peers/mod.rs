//! What else one could do with the same strikes: free every parameter, or sweep each effect over end points alone.
//!
//! Cheap forms of both, in the planar world: least squares in which every strike weighs the same and launches do not scatter, as
//! the paper and common practice have it. The third peer, a sparse regression on accelerations, is `tests/peers/sindy.py`.

mod endpoints;
mod fits;
mod sweep;

use serde::{Deserialize, Serialize};
use values::{Split, Strike};
use world::World;
use world::launch::{Launch, launches};

use super::cases::{Case, Kind};
use super::hide;
use super::set::{Made, Make, strikes};

use fits::{Candidate, Fits};

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Peers {
    pub id: String,
    /// Held-out strikes, and their rms stop error in m with every parameter freed; none where the set cannot be fitted.
    pub freed: Option<(usize, f64)>,
    /// The effect that BIC prefers over end points; none where chance makes such gains in one of a hundred draws or more.
    pub swept: Option<String>,
    /// The terms that the regression keeps beside friction, the largest first.
    pub regressed: Option<Vec<String>>,
}

/// The tracks of a set, as `sindy.py` reads them.
#[derive(Serialize)]
struct Tracks<'s> {
    id: &'s str,
    tracks: Vec<&'s values::Track>,
    order: Vec<f64>,
    session: Vec<usize>,
}

/// Sets that the peers are tried on: plain controls, and single effects at twice the floor and more.
pub fn is_for_peers(case: &Case) -> bool {
    match case.kind {
        Kind::Control => case.variant == "plain",
        Kind::Single => case.magnitude >= 2.0 && !case.is_box(),
        Kind::Pair | Kind::Foreign => false,
    }
}

/// What the peers make of a set, and a line for `sindy.py`.
pub fn peers(case: &Case) -> (Peers, Option<String>) {
    let mut found = Peers {
        id: case.id.clone(),
        freed: None,
        swept: None,
        regressed: None,
    };
    let tracks = fill(case, &mut found);
    (found, tracks)
}

fn fill(case: &Case, found: &mut Peers) -> Option<String> {
    let folder = tempfile::tempdir().ok()?;
    let truth = hide::truth(case)?;
    let make = Make::random(&truth, case.strikes);
    let Made {
        rig, strikes: all, ..
    } = strikes(make, folder.path())?;
    let world = World::nominal();
    let commanded = all.iter().map(Strike::commanded);
    let launched: Vec<(&Strike, Launch)> = all
        .iter()
        .zip(launches(&rig, &world, commanded).ok()?)
        .filter_map(|(strike, launch)| Some((strike, launch?)))
        .collect();
    let (judging, learning) = launched
        .into_iter()
        .partition(|(s, _)| s.split == Split::Test);
    let training = Fits {
        rig: &rig,
        strikes: learning,
    };
    let judges = Fits {
        rig: &rig,
        strikes: judging,
    };
    let mut sessions: Vec<&str> = all.iter().map(|s| s.conditions.session.as_str()).collect();
    sessions.dedup();
    let others = || sessions.iter().skip(1).map(|name| (name.to_string(), 0.0));
    let by_session = (sessions.len() > 1).then(|| Candidate {
        name: "friction_by_session".into(),
        parameters: others().collect(),
    });
    let learn: Vec<&Strike> = training.strikes.iter().map(|(strike, _)| *strike).collect();
    let tracks = Tracks {
        id: &case.id,
        tracks: learn.iter().map(|strike| &strike.track).collect(),
        order: learn.iter().map(|strike| strike.conditions.order).collect(),
        session: learn
            .iter()
            .map(|s| {
                sessions
                    .iter()
                    .position(|name| *name == s.conditions.session)
                    .unwrap_or(0)
            })
            .collect(),
    };
    found.freed = training.freed(&judges);
    found.swept = training.swept(by_session.as_slice(), case.seed);
    serde_json::to_string(&tracks).ok()
}
