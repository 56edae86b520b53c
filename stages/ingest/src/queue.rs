//! Episodes that wait for the centroids of their time, and which of them strike.

use std::collections::VecDeque;

use values::Rig;

use crate::episode::Episode;

/// At most this many commands wait (24 MB), and an episode counts as so many more.
const MOST_COMMANDS: usize = 1_000_000;
const EPISODE: usize = 8;

/// Episodes in their order.
#[derive(Default)]
pub(crate) struct Queue {
    episodes: VecDeque<Episode>,
    /// Index and start of those that strike, the first one left out.
    striking: VecDeque<(u32, i64)>,
    commands: usize,
}

impl Queue {
    /// Adds an episode. Blips do not strike, nor does an arm that goes back.
    pub(crate) fn push(&mut self, episode: Episode, rig: &Rig) {
        if !self.episodes.is_empty() && !episode.is_blip() && episode.is_towards_strikes(rig) {
            self.striking.push_back((episode.index, episode.start()));
        }
        self.commands += episode.commands.len() + EPISODE;
        self.episodes.push_back(episode);
    }

    /// The one that waits longest.
    pub(crate) fn first(&self) -> Option<&Episode> {
        self.episodes.front()
    }

    /// When the next episode after the first one strikes.
    pub(crate) fn next_strike(&self) -> Option<i64> {
        self.striking.front().map(|(_, start)| *start)
    }

    /// Takes the first one.
    pub(crate) fn pop(&mut self) -> Option<Episode> {
        let episode = self.episodes.pop_front()?;
        self.commands -= episode.commands.len() + EPISODE;
        let first = self.episodes.front().map(|first| first.index);
        if self.striking.front().map(|(index, _)| *index) == first {
            self.striking.pop_front();
        }
        Some(episode)
    }

    /// Whether more waits than may.
    pub(crate) fn is_full(&self) -> bool {
        self.commands > MOST_COMMANDS
    }
}
