//! Answers from the cache, or computed and kept.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use durable::{Lock, LockError};
use serde::Serialize;

use crate::answers::{Answers, Cached};
use crate::key::Key;
use crate::list::{self, ListAnswer};
use crate::pack::{self, CachedAnswer, Pack};
use crate::work_log::{self, Event};
use crate::worker::{Job, Share, Work, Worker, divide};
use crate::{
    ItemStage, ListStage, Progress, Record, RunError, Stage, StageError, StageSummary, Summary,
    codec,
};

/// Items of the first batch; later batches grow or shrink towards [`BATCH_TIME`].
const FIRST_BATCH: usize = 64;
/// How long a batch should take: what a kill loses, against what a sync costs.
const BATCH_TIME: Duration = Duration::from_secs(2);

/// The answers to items, block by block.
type Blocks = Vec<Vec<CachedAnswer>>;

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
    /// Held while items are answered: a pack has one reader and writer. For a worker, the blocks of the calls that it went past, by what
    /// their answers have in common: every other worker goes past the same ones.
    packs: Mutex<HashMap<Key, Vec<PathBuf>>>,
    account: Mutex<(Summary, Vec<Record>)>,
    worker: Option<Worker>,
    _lock: Lock,
}

impl Run {
    /// Begins a run in a folder, which is made; [`StageError::Busy`] where another run or a worker works there.
    pub fn open(dir: &Path, options: Options) -> Result<Self, StageError> {
        Self::begin(dir, options, Lock::acquire, |cache| {
            // Nobody works here: what workers say and claim is over.
            durable::remove_dir(&cache.join(work_log::FOLDER))?;
            Ok((Answers::open(cache.into())?, None))
        })
    }

    /// Begins work in a folder, which is made, beside any number of others; [`StageError::Busy`] where a run works there. Its answers are
    /// those of all.
    pub fn join(dir: &Path, options: Options, share: Share) -> Result<Self, StageError> {
        Self::begin(dir, options, Lock::share, |cache| {
            let worker = Worker::begin(cache, share)?;
            let answers = Answers::beside_others(cache.into(), worker.name().into());
            Ok((answers, Some(worker)))
        })
    }

    fn begin(
        dir: &Path,
        options: Options,
        lock: impl FnOnce(&Path) -> Result<Lock, LockError>,
        open: impl FnOnce(&Path) -> Result<(Answers, Option<Worker>), StageError>,
    ) -> Result<Self, StageError> {
        let cache = dir.join("cache");
        durable::create_dir(&cache)?;
        let lock = lock(&cache.join("lock")).map_err(|error| match error {
            LockError::Busy { .. } => StageError::Busy {
                dir: dir.display().to_string(),
            },
            LockError::Io(error) => error.into(),
        })?;
        let (answers, worker) = open(&cache)?;
        Ok(Self {
            dir: dir.into(),
            options,
            answers,
            packs: Mutex::default(),
            account: Mutex::default(),
            worker,
            _lock: lock,
        })
    }

    /// Adds to what this worker says of itself; a run that works alone says nothing.
    pub fn tell(&self, event: Event) {
        if let Some(worker) = self.worker() {
            worker.tell(event);
        }
    }

    /// The name that no other worker writes under; empty where the run works alone.
    pub fn writer(&self) -> &str {
        self.answers.writer()
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
        let damaged = AtomicUsize::new(0);
        let load = |_| -> Result<Option<S::Output>, RunError<S::Error>> {
            let output = match self.answers.load(&path, key)? {
                Cached::Nothing => return Ok(None),
                // It may have been kept by a stage of the same version with another type of output.
                Cached::Answer(bytes) => codec::decode(&bytes, S::NAME).ok(),
                Cached::Damaged => None,
            };
            damaged.store(usize::from(output.is_none()), Ordering::Relaxed);
            Ok(output)
        };
        let compute = |_, progress: &Progress| {
            let output = stage.run(input, progress).map_err(RunError::Stage)?;
            let bytes = codec::encode(&output, S::NAME)?;
            let output = codec::decode(&bytes, S::NAME)?;
            self.answers.store(&path, key, &bytes)?;
            Ok(output)
        };
        let jobs = [Job {
            key: key.to_string(),
            cost: 1,
            items: 0,
        }];
        let work = self.work(
            S::NAME,
            key.to_string(),
            &jobs,
            path.parent().unwrap_or(&path),
        );
        let (outputs, computed) = divide(self.worker(), &work, load, compute)?;
        if computed > 0 {
            self.answers.prune(S::NAME)?;
        }
        let damaged = damaged.into_inner();
        self.account_for(S::NAME, computed, 1 - computed, damaged, started);
        Ok(only(outputs, S::NAME, 1)?.remove(0))
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
        let mut blocks = lock(&self.packs);
        let mut fill = |key: Key, bytes: &[u8]| {
            for place in places.get(&key).into_iter().flatten() {
                // One that does not decode is as good as missing.
                slots[*place] = codec::decode(bytes, S::NAME).ok();
            }
        };
        let (mut pack, damaged) = Pack::open(path, group, &mut fill)?;
        if self.worker().is_none() {
            pack.absorb(&mut fill)?;
        }
        for path in blocks.get(&group).into_iter().flatten() {
            Pack::open(path.clone(), group, &mut fill)?;
        }
        self.answers.mark_used(pack.path());

        // Items that are equal are computed once, at the first one's place.
        let missing: BTreeMap<usize, Key> = places
            .iter()
            .filter(|(_, places)| slots[places[0]].is_none())
            .map(|(key, places)| (places[0], *key))
            .collect();
        let missing: Vec<(usize, Key)> = missing.into_iter().collect();
        let mut keep = |answers: Vec<CachedAnswer>| -> Result<(), StageError> {
            for (key, bytes) in answers {
                for place in &places[&key] {
                    slots[*place] = Some(codec::decode(&bytes, S::NAME)?);
                }
            }
            Ok(())
        };
        let answer = |batch: &[(usize, Key)], progress: &Progress| {
            answer_batch(stage, shared, items, batch, progress)
        };
        let mut computed = 0;
        if self.worker().is_some() {
            let past = blocks.entry(group).or_default();
            let answered = self.in_blocks::<S>(items, &pack, &missing, answer, past)?;
            computed = answered.1;
            answered.0.into_iter().try_for_each(keep)?;
        } else if !missing.is_empty() {
            let progress = self.progress(S::NAME).counted(missing.len());
            let mut size = FIRST_BATCH;
            while computed < missing.len() {
                let batch = &missing[computed..missing.len().min(computed + size)];
                let began = Instant::now();
                let answers = answer(batch, &progress)?;
                pack.append(&answers)?;
                keep(answers)?;
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
        Ok(only(answers, S::NAME, items.len())?)
    }

    /// The answers to the missing items, block by block, each a file until a run takes it in; and how many items were computed here. The
    /// files are added to `past`.
    fn in_blocks<S: ItemStage>(
        &self,
        items: &[S::Item],
        pack: &Pack,
        missing: &[(usize, Key)],
        answer: impl Fn(&[(usize, Key)], &Progress) -> Result<Vec<CachedAnswer>, RunError<S::Error>>
        + Sync,
        past: &mut Vec<PathBuf>,
    ) -> Result<(Blocks, usize), RunError<S::Error>> {
        let (group, folder) = (pack.group(), pack.parts());
        durable::create_dir(&folder)?;
        let blocks: Vec<&[(usize, Key)]> = missing.chunks(S::BLOCK).collect();
        let named = |block: &&[(usize, Key)]| {
            let keys: Vec<&[u8]> = block.iter().map(|(_, key)| &key.0[..]).collect();
            Job {
                key: Key::of_bytes(&[&[&group.0[..]], &keys[..]].concat()).to_string(),
                cost: block.iter().map(|(place, _)| S::cost(&items[*place])).sum(),
                items: block.len(),
            }
        };
        let jobs: Vec<Job> = blocks.iter().map(named).collect();
        let path = |block: usize| folder.join(format!("{}.part", jobs[block].key));
        let load = |block: usize| -> Result<_, RunError<S::Error>> {
            let mut held = HashMap::new();
            Pack::open(path(block), group, |key, bytes| {
                held.insert(key, bytes.to_vec());
            })?;
            let keys = blocks[block].iter();
            let answers = keys.map(|(_, key)| Some((*key, held.remove(key)?)));
            Ok(answers.collect())
        };
        let here = AtomicUsize::new(0);
        let compute = |block: usize, progress: &Progress| {
            let answers = answer(blocks[block], progress)?;
            pack::write_part(self.answers.writer(), &path(block), group, &answers)?;
            here.fetch_add(answers.len(), Ordering::Relaxed);
            Ok(answers)
        };
        let work = self.work(S::NAME, group.to_string(), &jobs, &folder);
        let (answers, _) = divide(self.worker(), &work, load, compute)?;
        past.extend((0..jobs.len()).map(path));
        Ok((answers, here.into_inner()))
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
        let distinct: Vec<(&list::Place, &S::Item)> = distinct.into_iter().collect();
        let job = |(place, item): &(&list::Place, &S::Item)| Job {
            key: place.name(),
            cost: S::cost(item),
            items: 1,
        };
        let jobs: Vec<Job> = distinct.iter().map(job).collect();

        let _guard = lock(&self.packs);
        let damaged = AtomicUsize::new(0);
        let load = |job: usize| match list::load::<S>(distinct[job].0)? {
            list::Cached::List(whole, entries) => {
                Ok::<_, RunError<S::Error>>(Some((whole, entries)))
            }
            list::Cached::Nothing => Ok(None),
            list::Cached::Damaged => {
                damaged.fetch_add(1, Ordering::Relaxed);
                Ok(None)
            }
        };
        let compute = |job: usize, progress: &Progress| {
            let (place, item) = distinct[job];
            list::write(self.answers.writer(), place, stage, shared, item)?;
            progress.inc(1);
            Ok::<_, RunError<S::Error>>(list::written::<S>(place)?)
        };
        let work = Work {
            is_side_by_side: true,
            ..self.work(S::NAME, group.to_string(), &jobs, &folder)
        };
        let (lists, computed) = divide(self.worker(), &work, load, compute)?;
        if computed > 0 {
            self.answers.prune(S::NAME)?;
        }
        let places_of = distinct.iter().map(|(place, _)| *place);
        let mut kept: BTreeMap<&list::Place, ListAnswer<S>> = places_of.zip(lists).collect();
        let lists = places
            .iter()
            .map(|place| match kept.remove(place) {
                Some(list) => Ok(list),
                None => list::written::<S>(place),
            })
            .collect::<Result<Vec<_>, StageError>>()?;
        let damaged = damaged.into_inner();
        self.account_for(S::NAME, computed, items.len() - computed, damaged, started);
        Ok(lists)
    }

    /// Answers of a kind that is kept elsewhere: each loaded from where it is kept, or computed there, by one of those who work in the
    /// folder. A job has a name and what it costs beside others.
    pub fn each<T: Send, E: From<StageError> + Send>(
        &self,
        stage: &'static str,
        jobs: &[(String, u64)],
        folder: &Path,
        load: impl Fn(usize) -> Result<Option<T>, E> + Sync,
        compute: impl Fn(usize) -> Result<T, E> + Sync,
    ) -> Result<Vec<T>, E> {
        let jobs = jobs.iter().map(|(key, cost)| Job {
            key: key.clone(),
            cost: *cost,
            items: 1,
        });
        let jobs: Vec<Job> = jobs.collect();
        let work = self.work(stage, stage.into(), &jobs, folder);
        let computed = |job, progress: &Progress| {
            let answer = compute(job)?;
            progress.inc(1);
            Ok(answer)
        };
        Ok(divide(self.worker(), &work, load, computed)?.0)
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

    fn work<'a>(
        &self,
        stage: &'static str,
        group: String,
        jobs: &'a [Job],
        folder: &'a Path,
    ) -> Work<'a> {
        Work {
            stage,
            group,
            jobs,
            is_side_by_side: false,
            folder,
            is_quiet: self.options.is_quiet,
        }
    }

    fn worker(&self) -> Option<&Worker> {
        self.worker.as_ref()
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

fn answer_batch<S: ItemStage>(
    stage: &S,
    shared: &S::Shared,
    items: &[S::Item],
    batch: &[(usize, Key)],
    progress: &Progress,
) -> Result<Vec<CachedAnswer>, RunError<S::Error>> {
    let wanted: Vec<&S::Item> = batch.iter().map(|(place, _)| &items[*place]).collect();
    let outputs = stage.run_items(shared, &wanted, progress);
    let outputs = only(outputs.map_err(RunError::Stage)?, S::NAME, batch.len())?;
    let answers = batch
        .iter()
        .zip(&outputs)
        .map(|((_, key), output)| Ok((*key, codec::encode(output, S::NAME)?)));
    answers.collect()
}

fn only<T>(answers: Vec<T>, stage: &'static str, items: usize) -> Result<Vec<T>, StageError> {
    if answers.len() == items {
        return Ok(answers);
    }
    Err(StageError::Rows {
        stage,
        answers: answers.len(),
        items,
    })
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
