//! The launch map as a candidate: fitted to all strikes, and judged by maps that learnt from the others.

use rayon::prelude::*;
use store::LaunchMap;

use crate::candidate::{Candidate, Kind};
use crate::groups::folds;
use crate::launch_map::fit_launch_map;
use crate::learning_set::LearningSet;
use crate::miss::Miss;

/// With fewer strikes no map is tried.
const LEAST_FOR_MAP: usize = 8;
/// Parts that are held out in turn.
const MAP_FOLDS: usize = 10;

impl LearningSet<'_> {
    /// The map of all strikes, or of those alone that were pushed once: whichever predicts all of them better, held out. An arm that
    /// catches up with the object may do so at the same commands again; pushed by chance, its strikes are outliers.
    pub(crate) fn launch_map(&mut self, seed: u64) -> Option<Candidate> {
        let of_all = self.map_as_set(seed)?;
        if self.rows.iter().all(|(row, _)| row.is_free) {
            return Some(of_all);
        }
        self.learns_pushed = false;
        let of_free = self.map_as_set(seed);
        let mean = |map: &Candidate| self.score(map).by_setting;
        let of_free = of_free.filter(|of_free| mean(of_free) < mean(&of_all));
        self.learns_pushed = of_free.is_none();
        of_free.or(Some(of_all))
    }

    fn map_as_set(&self, seed: u64) -> Option<Candidate> {
        let learnt = self.launches(|_| true);
        if learnt.len() < LEAST_FOR_MAP {
            return None;
        }
        let fitted = fit_launch_map(&learnt, None)?;
        let parts: Vec<Option<usize>> = folds(&self.groups, MAP_FOLDS, seed)
            .into_iter()
            .map(Some)
            .collect();
        let held_out = self.held_out_maps(&parts, Some(fitted.hyper))?;
        Some(Candidate {
            model: Some(fitted.map.into()),
            ..held_out
        })
    }

    /// What maps leave that learnt from the other parts; strikes of no part always learn, and are not predicted.
    pub(crate) fn held_out_maps(
        &self,
        parts: &[Option<usize>],
        near: Option<[[f64; 5]; 2]>,
    ) -> Option<Candidate> {
        let most = parts.iter().flatten().max()? + 1;
        let maps: Vec<Option<LaunchMap>> = (0..most)
            .into_par_iter()
            .map(|part| {
                let launches = self.launches(|i| parts[i] != Some(part));
                if launches.is_empty() {
                    return None;
                }
                Some(fit_launch_map(&launches, near)?.map)
            })
            .collect();
        let predicted = self
            .rows
            .iter()
            .zip(parts)
            .map(|((example, launch), part)| {
                let map = part.and_then(|part| maps[part].as_ref());
                map.map_or((Miss::of_launch(launch, [0.0; 2]), (0.0, false)), |map| {
                    let offset = map.offset(example.command);
                    let miss = Miss::of_launch(launch, [offset.speed, offset.angle]);
                    let is_among = map.outside(example.command) <= 0.0;
                    (miss, (offset.expected_miss(), is_among))
                })
            });
        let (misses, expectations): (Vec<Miss>, Vec<(f64, bool)>) = predicted.unzip();
        let (expected, is_within) = expectations.into_iter().unzip();
        Some(Candidate {
            kind: Kind::LaunchMap,
            model: None,
            misses,
            expected,
            is_within,
        })
    }
}
