//! Answers from the cache, or computed and kept.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use durable::{Lock, LockError};
use rayon::prelude::*;
use serde::Serialize;

use crate::answers::{Answers, Cached};
use crate::key::Key;
use crate::list::{self, ListAnswer};
use crate::pack::{CachedAnswer, Pack};
use crate::{
    ItemStage, ListStage, Progress, Record, RunError, Stage, StageError, StageSummary, Summary,
    codec,
};

/// Items of the first batch; later batches grow or shrink towards [`BATCH_TIME`].
const FIRST_BATCH: usize = 64;
/// How long a batch should take: what a kill loses, against what a sync costs.
const BATCH_TIME: Duration = Duration::from_secs(2);

/// How to run.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Versions of what computes below the stages (carom, MuJoCo): another engine's answers are not used.
    pub engine: String,
    /// Whether to show no progress.
    pub is_quiet: bool,
}

/// A run in one folder, which it locks while it lives. Usable from any thread.
pub struct Run {
    dir: PathBuf,
    options: Options,
    answers: Answers,
    /// Held while items are answered: a pack has one reader and writer.
    packs: Mutex<()>,
    account: Mutex<(Summary, Vec<Record>)>,
    _lock: Lock,
}

impl Run {
    /// Begins a run in a folder, which is made; [`StageError::Busy`] where another run works there.
    pub fn open(dir: &Path, options: Options) -> Result<Self, StageError> {
        let cache = dir.join("cache");
        durable::create_dir(&cache)?;
        let lock = Lock::acquire(&cache.join("lock")).map_err(|error| match error {
            LockError::Busy { .. } => StageError::Busy {
                dir: dir.display().to_string(),
            },
            LockError::Io(error) => error.into(),
        })?;
        let answers = Answers::open(cache)?;
        Ok(Self {
            dir: dir.into(),
            options,
            answers,
            packs: Mutex::default(),
            account: Mutex::default(),
            _lock: lock,
        })
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// What was computed and what reused so far.
    pub fn summary(&self) -> Summary {
        lock(&self.account).0.clone()
    }

    /// How each stage was run so far, in order, each kind of run once.
    pub fn records(&self) -> Vec<Record> {
        lock(&self.account).1.clone()
    }

    /// The stage's answer: kept, or computed now and kept. Either way it is what the cache's bytes say.
    pub fn stage<S: Stage>(
        &self,
        stage: &S,
        input: &S::Input,
    ) -> Result<S::Output, RunError<S::Error>> {
        let started = Instant::now();
        self.record(S::NAME, S::VERSION, stage)?;
        let key = Key::of(S::NAME, S::VERSION, &self.options.engine, stage, input)?;
        let path = self.answers.path(S::NAME, key, "answer")?;
        let mut damaged = 0;
        match self.answers.load(&path, key)? {
            Cached::Answer(bytes) => match codec::decode(&bytes, S::NAME) {
                Ok(output) => {
                    self.account_for(S::NAME, 0, 1, 0, started);
                    return Ok(output);
                }
                // Kept by a stage of the same version with another type of output.
                Err(_) => damaged = 1,
            },
            Cached::Damaged => damaged = 1,
            Cached::Nothing => {}
        }
        let output = stage
            .run(input, &self.progress(S::NAME))
            .map_err(RunError::Stage)?;
        let bytes = codec::encode(&output, S::NAME)?;
        let output = codec::decode(&bytes, S::NAME)?;
        self.answers.store(&path, key, &bytes)?;
        self.answers.prune(S::NAME)?;
        self.account_for(S::NAME, 1, 0, damaged, started);
        Ok(output)
    }

    /// The answers to the items, in their order: each kept, or computed now and kept. Calls follow one another: not to
    /// be made from within a rayon task, which another call may be waiting for.
    pub fn items<S: ItemStage>(
        &self,
        stage: &S,
        shared: &S::Shared,
        items: &[S::Item],
    ) -> Result<Vec<S::Output>, RunError<S::Error>> {
        let started = Instant::now();
        self.record(S::NAME, S::VERSION, stage)?;
        let keys = items
            .iter()
            .map(|item| Key::of_item(S::NAME, item))
            .collect::<Result<Vec<_>, _>>()?;
        let mut places: HashMap<Key, Vec<usize>> = HashMap::new();
        for (place, key) in keys.iter().enumerate() {
            places.entry(*key).or_default().push(place);
        }
        let mut slots: Vec<Option<S::Output>> = items.iter().map(|_| None).collect();

        let group = Key::of(S::NAME, S::VERSION, &self.options.engine, stage, shared)?;
        let path = self.answers.path(S::NAME, group, "pack")?;
        let _guard = lock(&self.packs);
        let (mut pack, damaged) = Pack::open(path, group, |key, bytes| {
            for place in places.get(&key).into_iter().flatten() {
                // One that does not decode is as good as missing.
                slots[*place] = codec::decode(bytes, S::NAME).ok();
            }
        })?;
        self.answers.mark_used(pack.path());

        // Items that are equal are computed once, at the first one's place.
        let missing: BTreeMap<usize, Key> = places
            .iter()
            .filter(|(_, places)| slots[places[0]].is_none())
            .map(|(key, places)| (places[0], *key))
            .collect();
        let missing: Vec<(usize, Key)> = missing.into_iter().collect();
        let mut computed = 0;
        if !missing.is_empty() {
            let progress = self.progress(S::NAME).counted(missing.len());
            let mut size = FIRST_BATCH;
            while computed < missing.len() {
                let batch = &missing[computed..missing.len().min(computed + size)];
                let began = Instant::now();
                for (key, bytes) in
                    self.compute(stage, shared, items, batch, &progress, &mut pack)?
                {
                    for place in &places[&key] {
                        slots[*place] = Some(codec::decode(&bytes, S::NAME)?);
                    }
                }
                computed += batch.len();
                progress.set_done(computed);
                size = next_size(size, began.elapsed());
            }
            self.answers.prune(S::NAME)?;
        }
        self.account_for(
            S::NAME,
            computed,
            items.len() - computed,
            usize::from(damaged),
            started,
        );
        let answers = slots.into_iter().flatten().collect::<Vec<_>>();
        if answers.len() == items.len() {
            Ok(answers)
        } else {
            Err(StageError::Rows {
                stage: S::NAME,
                answers: answers.len(),
                items: items.len(),
            }
            .into())
        }
    }

    /// The lists of the items, in their order: each kept, or computed now and kept. Calls follow one another, as those of
    /// [`Run::items`] do.
    pub fn lists<S: ListStage>(
        &self,
        stage: &S,
        shared: &S::Shared,
        items: &[S::Item],
    ) -> Result<Vec<ListAnswer<S>>, RunError<S::Error>> {
        let started = Instant::now();
        self.record(S::NAME, S::VERSION, stage)?;
        let group = Key::of(S::NAME, S::VERSION, &self.options.engine, stage, shared)?;
        let folder = self.answers.path(S::NAME, group, "lists")?;
        durable::create_dir(&folder)?;
        self.answers.mark_used(&folder);
        let places = items
            .iter()
            .map(|item| list::Place::of::<S>(&folder, group, item))
            .collect::<Result<Vec<_>, StageError>>()?;
        // Items that are equal have one file.
        let distinct: BTreeMap<&list::Place, &S::Item> = places.iter().zip(items).collect();

        let _guard = lock(&self.packs);
        let mut kept = distinct
            .par_iter()
            .map(|(place, _)| Ok((*place, list::load::<S>(place)?)))
            .collect::<Result<BTreeMap<&list::Place, list::Cached<S>>, StageError>>()?;
        let missing: Vec<&list::Place> = distinct
            .keys()
            .copied()
            .filter(|place| !matches!(kept[*place], list::Cached::List(..)))
            .collect();
        let damaged = kept
            .values()
            .filter(|kept| matches!(kept, list::Cached::Damaged))
            .count();
        if !missing.is_empty() {
            let progress = self.progress(S::NAME).counted(missing.len());
            missing.par_iter().try_for_each(|place| {
                list::write(place, stage, shared, distinct[*place])?;
                progress.inc(1);
                Ok::<_, RunError<S::Error>>(())
            })?;
            self.answers.prune(S::NAME)?;
        }
        let computed = missing.len();
        let lists = places
            .iter()
            .map(|place| match kept.remove(place) {
                Some(list::Cached::List(whole, entries)) => Ok((whole, entries)),
                _ => list::written::<S>(place),
            })
            .collect::<Result<Vec<_>, StageError>>()?;
        self.account_for(S::NAME, computed, items.len() - computed, damaged, started);
        Ok(lists)
    }

    /// The list of an item that the cache still holds; none where it holds none. Nothing is computed.
    pub fn kept_list<S: ListStage>(
        &self,
        stage: &S,
        shared: &S::Shared,
        item: &S::Item,
    ) -> Result<Option<ListAnswer<S>>, StageError> {
        let group = Key::of(S::NAME, S::VERSION, &self.options.engine, stage, shared)?;
        let folder = self.answers.path(S::NAME, group, "lists")?;
        let kept = list::load::<S>(&list::Place::of::<S>(&folder, group, item)?)?;
        Ok(match kept {
            list::Cached::List(whole, entries) => Some((whole, entries)),
            list::Cached::Nothing | list::Cached::Damaged => None,
        })
    }

    /// Computes one batch and keeps it.
    fn compute<S: ItemStage>(
        &self,
        stage: &S,
        shared: &S::Shared,
        items: &[S::Item],
        batch: &[(usize, Key)],
        progress: &Progress,
        pack: &mut Pack,
    ) -> Result<Vec<CachedAnswer>, RunError<S::Error>> {
        let wanted: Vec<&S::Item> = batch.iter().map(|(place, _)| &items[*place]).collect();
        let outputs = stage
            .run_items(shared, &wanted, progress)
            .map_err(RunError::Stage)?;
        if outputs.len() != batch.len() {
            return Err(StageError::Rows {
                stage: S::NAME,
                answers: outputs.len(),
                items: batch.len(),
            }
            .into());
        }
        let answers = batch
            .iter()
            .zip(&outputs)
            .map(|((_, key), output)| Ok((*key, codec::encode(output, S::NAME)?)))
            .collect::<Result<Vec<_>, StageError>>()?;
        pack.append(&answers)?;
        Ok(answers)
    }

    fn progress(&self, stage: &'static str) -> Progress {
        if self.options.is_quiet {
            Progress::hidden()
        } else {
            Progress::shown(stage)
        }
    }

    fn record<S: Serialize>(
        &self,
        name: &'static str,
        version: u32,
        settings: &S,
    ) -> Result<(), StageError> {
        let settings = serde_json::to_value(settings).map_err(|error| StageError::Encode {
            stage: name,
            what: "the settings",
            why: error.to_string(),
        })?;
        let record = Record {
            name,
            version,
            settings,
        };
        let records = &mut lock(&self.account).1;
        if !records.contains(&record) {
            records.push(record);
        }
        Ok(())
    }

    fn account_for(
        &self,
        name: &'static str,
        computed: usize,
        reused: usize,
        damaged: usize,
        started: Instant,
    ) {
        let seconds = started.elapsed().as_secs_f64();
        lock(&self.account).0.add(StageSummary {
            name,
            computed,
            reused,
            damaged,
            seconds,
        });
    }
}

/// Twice as many items where a batch was quick, half as many where it was slow. How items are cut into batches changes
/// no answer and no byte of the pack.
fn next_size(size: usize, took: Duration) -> usize {
    if took < BATCH_TIME / 2 {
        size * 2
    } else if took > BATCH_TIME * 2 {
        (size / 2).max(1)
    } else {
        size
    }
}

/// What a panic of another thread left is whole: each guarded value changes in one step.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
