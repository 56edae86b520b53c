//! `--watch`: the object where the camera sees it, before and after the strike.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use strike::{Args, Live, Resting, Watched};
use values::Rig;

use super::Failure;

/// How long the object is waited for to be seen at rest before a strike.
const BEFORE: Duration = Duration::from_secs(3);

/// The live topics, and the object at rest.
pub struct Watching {
    live: Arc<Live>,
    pub rest: Resting,
    pub strike: Watched,
}

impl Watching {
    /// Connects where `--watch` is given, and looks where the object rests.
    pub fn open(args: &Args, rig: &Rig) -> Result<Option<Self>, Failure> {
        let Some(url) = &args.watch else {
            return Ok(None);
        };
        let live = Arc::new(Live::connect(url, rig)?);
        let rest = live.wait_for_rest(BEFORE, &AtomicBool::new(false))?;
        Ok(Some(Self {
            strike: Watched::new(live.clone(), rest),
            live,
            rest,
        }))
    }

    /// Greatest size in bytes that the messages of a strike may come to.
    pub fn room(&self) -> u64 {
        self.live.room()
    }
}
