//! Many processes on one run's cache, on any machines that see its folder.
//!
//! Each job has a claim, a file that is locked while a worker computes it: the lock goes with the process, however that ends. Claims
//! only save work. What makes a result right is that an answer depends on nothing but its key, and that its file is whole or absent:
//! computed twice, it is the same file twice.

use std::cmp::Reverse;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use durable::{Lock, LockError};
use rayon::prelude::*;

use crate::work_log::{Event, FOLDER, LOGS, Line};
use crate::{Progress, StageError};

/// How long a worker waits for a job that another one computes before one of those who wait computes it as well, where it computed none of
/// the kind itself: longer than stages that answer as a whole take.
pub const PATIENCE: Duration = Duration::from_secs(1200);
/// How long it waits for such a job where it computed one of the kind: this many times the job's cost at the slowest pace that it saw, and this part
/// of its patience at the least.
const SLOWER: f64 = 20.0;
/// How often a worker that waits looks again: at first, and at the most.
const PAUSES: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(500)];

/// The part of a run's work that a worker begins with; it goes on with what the others have not begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Number of the share, from 0.
    pub index: usize,
    /// Number of shares.
    pub count: usize,
    /// How long to wait for a worker that neither answers nor ends, where nothing says how long its job takes.
    pub patience: Duration,
}

/// What is computed once by all who work in a folder.
pub(crate) struct Job {
    /// Its name among the stage's jobs: no two have the same.
    pub key: String,
    /// How much there is to do, beside other jobs of the stage.
    pub cost: u64,
    /// Items that it answers; 0 where the stage counts by itself.
    pub items: usize,
}

/// A stage's jobs.
pub(crate) struct Work<'a> {
    pub stage: &'static str,
    /// What all its jobs have in common.
    pub group: String,
    pub jobs: &'a [Job],
    /// Whether each job uses one thread.
    pub is_side_by_side: bool,
    /// Where the answers appear.
    pub folder: &'a Path,
    pub is_quiet: bool,
}

/// One process of those that work in a folder.
pub(crate) struct Worker {
    name: String,
    share: Share,
    claims: PathBuf,
    /// Locked while the worker lives.
    log: Mutex<File>,
}

impl Worker {
    /// A worker with a name that no other one has had.
    pub fn begin(cache: &Path, share: Share) -> Result<Self, StageError> {
        let claims = cache.join(FOLDER).join("claims");
        let logs = cache.join(FOLDER).join(LOGS);
        durable::create_dir(&claims)?;
        durable::create_dir(&logs)?;
        let host = rustix::system::uname();
        let host = host.nodename().to_string_lossy().replace('/', "_");
        let process = std::process::id();
        for number in 0.. {
            let name = format!("{host}_{process}_{number}");
            let path = logs.join(format!("{name}.jsonl"));
            let opened = OpenOptions::new().create_new(true).append(true).open(&path);
            let log = match opened {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                opened => opened.and_then(|log| log.lock().map(|()| log)),
            };
            let log = log.map_err(|error| durable::Error::new("begin", &path, error))?;
            let worker = Self {
                name,
                share,
                claims,
                log: Mutex::new(log),
            };
            worker.tell(Event::Began {
                host,
                process,
                shard: [share.index, share.count],
            });
            return Ok(worker);
        }
        unreachable!("numbers do not end")
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Adds a line to the log, for people: a disk that does not take it stops no work.
    pub fn tell(&self, event: Event) {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        drop(log.write_all(Line::now(event).to_json().as_bytes()));
    }

    /// The job's claim; none where another worker holds it.
    fn claim(&self, work: &Work<'_>, name: &str) -> Result<Option<Lock>, StageError> {
        let path = self.claims.join(format!("{}_{name}", work.stage));
        match Lock::acquire(&path) {
            Ok(lock) => {
                // An NFS client may remember that an answer is not there; opening its folder makes it ask the server again.
                drop(File::open(work.folder));
                Ok(Some(lock))
            }
            Err(LockError::Busy { .. }) => Ok(None),
            Err(LockError::Io(error)) => Err(error.into()),
        }
    }

    /// The missing jobs in the order that this worker takes them: its own share, the largest first; then the others', the largest first, too,
    /// and of those that cost the same the last. Jobs are dealt by falling cost, to and fro, so that the shares weigh the same.
    fn order(&self, jobs: &[Job], missing: &[usize]) -> Vec<usize> {
        let Share { index, count, .. } = self.share;
        let mut order = missing.to_vec();
        order.sort_by_key(|place| Reverse(jobs[*place].cost));
        let is_own = |rank: usize| [index, 2 * count - 1 - index].contains(&(rank % (2 * count)));
        let ranked = order.into_iter().enumerate();
        let (mut own, mut others): (Vec<_>, Vec<_>) = ranked.partition(|(rank, _)| is_own(*rank));
        others.sort_by_key(|(rank, place)| Reverse((jobs[*place].cost, *rank)));
        own.extend(others);
        own.into_iter().map(|(_, place)| place).collect()
    }
}

/// All answers, each kept or computed, here or by another worker; and how many were computed here.
pub(crate) fn divide<T: Send, E: From<StageError> + Send>(
    worker: Option<&Worker>,
    work: &Work<'_>,
    load: impl Fn(usize) -> Result<Option<T>, E> + Sync,
    compute: impl Fn(usize, &Progress) -> Result<T, E> + Sync,
) -> Result<(Vec<T>, usize), E> {
    let places = 0..work.jobs.len();
    let kept = places.clone().into_par_iter().map(&load);
    let kept = kept.collect::<Result<Vec<Option<T>>, E>>()?;
    let missing: Vec<usize> = places.filter(|place| kept[*place].is_none()).collect();
    if let Some(worker) = worker {
        worker.tell(Event::Found {
            stage: work.stage.into(),
            group: work.group.clone(),
            jobs: work.jobs.len(),
            missing: missing.len(),
        });
    }
    let slots: Vec<Mutex<Option<T>>> = kept.into_iter().map(Mutex::new).collect();
    let computed = AtomicUsize::new(0);
    // The slowest so far, in s for what costs 1.
    let pace = Mutex::new(0.0_f64);
    if !missing.is_empty() {
        let progress = work.progress(&missing);
        let answer = |place: usize| -> Result<(), E> {
            let began = Instant::now();
            let answer = compute(place, &progress)?;
            let seconds = began.elapsed().as_secs_f64() / work.jobs[place].cost.max(1) as f64;
            let mut pace = pace.lock().unwrap_or_else(PoisonError::into_inner);
            *pace = pace.max(seconds);
            *slot(&slots, place) = Some(answer);
            computed.fetch_add(1, Ordering::Relaxed);
            Ok(())
        };
        let is_answered = |place: usize| -> Result<bool, E> {
            let mut slot = slot(&slots, place);
            if slot.is_none() {
                *slot = load(place)?;
                progress.inc(slot.as_ref().map_or(0, |_| work.jobs[place].items));
            }
            Ok(slot.is_some())
        };
        match worker {
            None => work.each(&missing, answer)?,
            Some(worker) => {
                let order = worker.order(work.jobs, &missing);
                let attempt =
                    |place, round| worker.attempt(work, place, round, is_answered, answer);
                work.each(&order, |place| attempt(place, 0).map(drop))?;
                // What is left others compute.
                for place in order {
                    let pace = *pace.lock().unwrap_or_else(PoisonError::into_inner);
                    let usual = pace * work.jobs[place].cost.max(1) as f64;
                    worker.wait(work, usual, |round| attempt(place, round))?;
                }
            }
        }
    }
    let answers = slots.into_iter();
    let answers =
        answers.filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
    Ok((answers.collect(), computed.into_inner()))
}

impl Work<'_> {
    fn progress(&self, missing: &[usize]) -> Progress {
        let progress = match self.is_quiet {
            true => Progress::hidden(),
            false => Progress::shown(self.stage),
        };
        match missing.iter().map(|place| self.jobs[*place].items).sum() {
            0 => progress,
            items => progress.counted(items),
        }
    }

    fn each<E: Send>(
        &self,
        places: &[usize],
        act: impl Fn(usize) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        match self.is_side_by_side {
            // In their order, whichever thread is free.
            true => places.iter().par_bridge().try_for_each(|place| act(*place)),
            false => places.iter().try_for_each(|place| act(*place)),
        }
    }
}

impl Worker {
    /// Whether the job is answered: it was, or no other worker is at it and this one answers. `round` counts how often patience ended.
    fn attempt<E: From<StageError>>(
        &self,
        work: &Work<'_>,
        place: usize,
        round: u128,
        is_answered: impl Fn(usize) -> Result<bool, E>,
        answer: impl Fn(usize) -> Result<(), E>,
    ) -> Result<bool, E> {
        if is_answered(place)? {
            return Ok(true);
        }
        let Job { key, items, .. } = &work.jobs[place];
        let claim = match self.claim(work, key)? {
            None if round > 0 => self.claim(work, &format!("{key}_{round}"))?,
            claim => claim,
        };
        if claim.is_none() {
            return Ok(false);
        }
        // Between the look and the claim.
        if is_answered(place)? {
            return Ok(true);
        }
        self.tell(Event::Took {
            stage: work.stage.into(),
        });
        let started = Instant::now();
        answer(place)?;
        self.tell(Event::Done {
            stage: work.stage.into(),
            group: work.group.clone(),
            job: key.clone(),
            items: *items,
            seconds: started.elapsed().as_secs_f64(),
        });
        Ok(true)
    }

    /// Tries until it is answered. `usual` is what it usually takes, in s; 0 where that is not known.
    fn wait<E>(
        &self,
        work: &Work<'_>,
        usual: f64,
        attempt: impl Fn(u128) -> Result<bool, E>,
    ) -> Result<(), E> {
        let (began, mut pause) = (Instant::now(), PAUSES[0]);
        let patience = patience(usual, self.share.patience.as_secs_f64());
        let patience = Duration::from_secs_f64(patience).as_millis().max(1);
        while !attempt(began.elapsed().as_millis() / patience)? {
            if pause == PAUSES[0] {
                self.tell(Event::Waits {
                    stage: work.stage.into(),
                });
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(PAUSES[1]);
        }
        Ok(())
    }
}

fn slot<T>(slots: &[Mutex<Option<T>>], place: usize) -> MutexGuard<'_, Option<T>> {
    slots[place].lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long to wait for a job that usually takes so long, 0 where that is not known, when nothing says more than this; in s.
fn patience(usual: f64, unknown: f64) -> f64 {
    match usual > 0.0 {
        true => (SLOWER * usual).max(unknown / SLOWER),
        false => unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_dealt_once_each_and_weigh_the_same() {
        let dir = tempfile::tempdir().expect("folder");
        let jobs: Vec<Job> = (0..100_u64)
            .map(|job| Job {
                key: job.to_string(),
                cost: (job * job) % 89,
                items: 1,
            })
            .collect();
        let missing: Vec<usize> = (0..100).collect();
        let mut dealt = Vec::new();
        let mut weights = Vec::new();
        for index in 0..5 {
            let share = Share {
                index,
                count: 5,
                patience: PATIENCE,
            };
            let worker = Worker::begin(dir.path(), share).expect("begins");
            let order = worker.order(&jobs, &missing);
            let mut all = order.clone();
            all.sort_unstable();
            assert_eq!(all, missing, "each worker goes on with what others left");
            let own = &order[..20];
            weights.push(own.iter().map(|place| jobs[*place].cost).sum::<u64>());
            dealt.extend_from_slice(own);
        }
        dealt.sort_unstable();
        assert_eq!(dealt, missing);
        let [least, most] = [weights.iter().min(), weights.iter().max()].map(|w| *w.expect("five"));
        assert!(most - least <= 89, "{weights:?}");
    }

    #[test]
    fn a_job_is_waited_for_by_what_it_usually_takes_where_that_is_known() {
        assert_eq!(patience(0.0, 2.0), 2.0);
        assert_eq!(patience(1.0, 2.0), SLOWER);
        // A twentieth of the patience at the least.
        assert_eq!(patience(1e-4, 2.0), 2.0 / SLOWER);
    }
}
