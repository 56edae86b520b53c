//! Strikes as a LeRobotDataset of version 3: a folder with `data/`, `meta/episodes/`, `meta/tasks.parquet`, `meta/stats.json` and, last,
//! `meta/info.json`, without which the folder is no dataset.

mod stats;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use arrow::array::{
    Array, ArrayRef, FixedSizeListArray, Float32Array, Float64Array, Int64Array, ListArray,
    RecordBatch, StringArray,
};
use arrow::buffer::OffsetBuffer;
use arrow::datatypes::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::errors::ParquetError;
use serde_json::{Map, Value, json};
use values::Split;

use self::stats::{MOMENTS, QUANTILES, Stats, Summary};
use crate::TableError;
use crate::write::common;

const VERSION: &str = "v3.0";
/// Files of a folder, and rows of a file: fewer than 100 MB, as the format asks.
const FILES: usize = 1000;
const ROWS: usize = 1 << 20;
/// What an action's numbers are: the command, and the velocity of the tip that went with it.
const ACTION: [&str; 4] = ["speed", "angle", "tip_vx", "tip_vy"];
const SPLITS: [Split; 3] = [Split::Train, Split::Validation, Split::Test];

/// A strike as an episode: a row a frame, from where it was struck on, at equal distances in time.
pub struct Episode {
    /// The strike.
    pub strike_id: String,
    /// Its part: episodes of one part follow each other.
    pub split: Split,
    /// What was to be done, in words.
    pub task: String,
    /// Where the object is: x, y in m, and its yaw in rad where that is told of all.
    pub states: Vec<[f32; 3]>,
    /// Speed in m/s and angle in rad as commanded, relative to an object that moved, and the tip's velocity in m/s: at the frame that the strike
    /// follows, 0 elsewhere.
    pub actions: Vec<[f32; 4]>,
}

struct Feature {
    name: &'static str,
    dtype: &'static str,
    names: Option<Vec<&'static str>>,
    /// Numbers of a row.
    width: usize,
}

/// Writes episodes of `fps` frames a second into a folder.
pub fn write_lerobot(
    dir: &Path,
    fps: u32,
    with_yaw: bool,
    mut episodes: Vec<Episode>,
) -> Result<(), TableError> {
    let place = |split: Split| SPLITS.iter().position(|other| *other == split);
    episodes.sort_by_key(|episode| place(episode.split));
    let features = features(with_yaw);
    let mut tasks: Vec<&str> = Vec::new();
    let mut known: HashMap<&str, usize> = HashMap::new();
    for Episode { task, .. } in &episodes {
        known.entry(task).or_insert_with(|| {
            tasks.push(task);
            tasks.len() - 1
        });
    }

    let none = || features.iter().map(|feature| Stats::new(feature.width));
    let mut all: Vec<Stats> = none().collect();
    let mut of_episodes: Vec<Vec<Summary>> = Vec::new();
    let (mut ranges, mut files): (Vec<(usize, usize)>, Vec<usize>) = (Vec::new(), Vec::new());
    // Numbers of a file, by feature.
    let mut numbers: Vec<Vec<f64>> = vec![Vec::new(); features.len()];
    let (mut index, mut in_file, mut file) = (0, 0, 0);
    for (at, episode) in episodes.iter().enumerate() {
        let frames = episode.states.len();
        if in_file > 0 && in_file + frames > ROWS {
            write_data(dir, file, &features, &mut numbers)?;
            (in_file, file) = (0, file + 1);
        }
        let mut own: Vec<Stats> = none().collect();
        let task = known[&*episode.task];
        for frame in 0..frames {
            let row = row(episode, frame, fps, with_yaw, [at, index + frame, task]);
            for (feature, row) in row.iter().enumerate() {
                all[feature].push(row);
                own[feature].push(row);
                numbers[feature].extend(row);
            }
        }
        of_episodes.push(own.into_iter().map(Stats::summary).collect());
        ranges.push((index, index + frames));
        files.push(file);
        index += frames;
        in_file += frames;
    }
    write_data(dir, file, &features, &mut numbers)?;

    let stats: Map<String, Value> = features
        .iter()
        .zip(all)
        .map(|(feature, stats)| (feature.name.into(), stats.summary().json()))
        .collect();
    write_tasks(dir, &tasks)?;
    write_episodes(dir, &episodes, &features, of_episodes, &ranges, &files)?;
    write_json(&dir.join("meta/stats.json"), &Value::Object(stats))?;
    let info = info(fps, &episodes, tasks.len(), index, &features);
    write_json(&dir.join("meta/info.json"), &info)
}

fn features(with_yaw: bool) -> Vec<Feature> {
    let state = if with_yaw {
        vec!["x", "y", "yaw"]
    } else {
        vec!["x", "y"]
    };
    let numbers = |name, names: Vec<&'static str>| Feature {
        name,
        dtype: "float32",
        width: names.len(),
        names: Some(names),
    };
    let number = |name, dtype| Feature {
        name,
        dtype,
        names: None,
        width: 1,
    };
    vec![
        numbers("observation.state", state),
        numbers("action", ACTION.to_vec()),
        number("timestamp", "float32"),
        number("frame_index", "int64"),
        number("episode_index", "int64"),
        number("index", "int64"),
        number("task_index", "int64"),
    ]
}

/// The numbers of a frame, by feature; the last are those of its episode, of all frames, and of its task.
fn row(
    episode: &Episode,
    frame: usize,
    fps: u32,
    with_yaw: bool,
    [at, index, task]: [usize; 3],
) -> Vec<Vec<f64>> {
    let state = &episode.states[frame][..if with_yaw { 3 } else { 2 }];
    let real = |numbers: &[f32]| numbers.iter().copied().map(f64::from).collect();
    let time = frame as f64 / f64::from(fps);
    vec![
        real(state),
        real(&episode.actions[frame]),
        vec![time],
        vec![frame as f64],
        vec![at as f64],
        vec![index as f64],
        vec![task as f64],
    ]
}

fn write_data(
    dir: &Path,
    file: usize,
    features: &[Feature],
    numbers: &mut [Vec<f64>],
) -> Result<(), TableError> {
    let numbers = numbers.iter_mut().map(std::mem::take);
    let columns = features.iter().zip(numbers);
    let columns = columns.map(|(feature, numbers)| column(feature, numbers));
    let path = dir.join("data").join(place(file));
    write_columns(&path, columns.collect(), None)
}

/// A feature's numbers as a column: a list a row where there are several.
fn column(feature: &Feature, numbers: Vec<f64>) -> Column {
    let whole = |numbers: Vec<f64>| numbers.into_iter().map(|n| n as i64).collect::<Vec<_>>();
    let values: ArrayRef = match feature.dtype {
        "int64" => Arc::new(Int64Array::from(whole(numbers))),
        _ => {
            let short = numbers.into_iter().map(|n| n as f32);
            Arc::new(Float32Array::from(short.collect::<Vec<_>>()))
        }
    };
    let array: ArrayRef = if feature.width == 1 {
        values
    } else {
        let item = Arc::new(Field::new("element", values.data_type().clone(), true));
        let width = feature.width as i32;
        Arc::new(FixedSizeListArray::new(item, width, values, None))
    };
    let field = Field::new(feature.name, array.data_type().clone(), true);
    (field, array)
}

fn whole_numbers(name: &str, numbers: impl Iterator<Item = usize>) -> Column {
    let numbers: Vec<i64> = numbers.map(|n| n as i64).collect();
    (
        Field::new(name, DataType::Int64, true),
        Arc::new(Int64Array::from(numbers)),
    )
}

fn texts<'a>(name: &str, texts: impl Iterator<Item = &'a str>) -> Column {
    let array = StringArray::from_iter_values(texts);
    (Field::new(name, DataType::Utf8, true), Arc::new(array))
}

fn lists(name: &str, values: ArrayRef, lengths: impl Iterator<Item = usize>) -> Column {
    let item = Arc::new(Field::new("element", values.data_type().clone(), true));
    let offsets = OffsetBuffer::from_lengths(lengths);
    let array = ListArray::new(item, offsets, values, None);
    let field = Field::new(name, array.data_type().clone(), true);
    (field, Arc::new(array))
}

/// pandas' own words for which column is the index: readers look tasks up by their text.
fn write_tasks(dir: &Path, tasks: &[&str]) -> Result<(), TableError> {
    let pandas = json!({
        "index_columns": ["task"],
        "column_indexes": [{ "name": null, "field_name": null, "pandas_type": "unicode", "numpy_type": "object", "metadata": { "encoding": "UTF-8" } }],
        "columns": [
            { "name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64", "metadata": null },
            { "name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object", "metadata": null },
        ],
        "creator": { "library": "carom", "version": env!("CARGO_PKG_VERSION") },
        "pandas_version": "2.0.0",
    });
    let columns = vec![
        whole_numbers("task_index", 0..tasks.len()),
        texts("task", tasks.iter().copied()),
    ];
    let path = dir.join("meta/tasks.parquet");
    write_columns(&path, columns, Some(("pandas", pandas.to_string())))
}

fn write_episodes(
    dir: &Path,
    episodes: &[Episode],
    features: &[Feature],
    stats: Vec<Vec<Summary>>,
    ranges: &[(usize, usize)],
    files: &[usize],
) -> Result<(), TableError> {
    let ones = || episodes.iter().map(|_| 1);
    let zeros = || episodes.iter().map(|_| 0);
    let tasks = StringArray::from_iter_values(episodes.iter().map(|episode| &*episode.task));
    let mut columns = vec![
        whole_numbers("episode_index", 0..episodes.len()),
        lists("tasks", Arc::new(tasks), ones()),
        whole_numbers("length", ranges.iter().map(|(from, to)| to - from)),
        whole_numbers("data/chunk_index", files.iter().map(|file| file / FILES)),
        whole_numbers("data/file_index", files.iter().map(|file| file % FILES)),
        whole_numbers("dataset_from_index", ranges.iter().map(|range| range.0)),
        whole_numbers("dataset_to_index", ranges.iter().map(|range| range.1)),
        texts(
            "strike_id",
            episodes.iter().map(|episode| &*episode.strike_id),
        ),
    ];
    for (at, feature) in features.iter().enumerate() {
        let name = |what: &str| format!("stats/{}/{what}", feature.name);
        let of = || stats.iter().map(|own| &own[at]);
        let widths = || episodes.iter().map(|_| feature.width);
        let reals = |numbers: Vec<f64>| -> ArrayRef { Arc::new(Float64Array::from(numbers)) };
        for (place, what) in MOMENTS.into_iter().enumerate() {
            let numbers = of().flat_map(|own| own.moments[place].clone()).collect();
            columns.push(lists(&name(what), reals(numbers), widths()));
        }
        let counts: Vec<i64> = ranges.iter().map(|(from, to)| (to - from) as i64).collect();
        columns.push(lists(
            &name("count"),
            Arc::new(Int64Array::from(counts)),
            ones(),
        ));
        for (place, (what, _)) in QUANTILES.into_iter().enumerate() {
            let numbers = of().flat_map(|own| own.quantiles[place].clone()).collect();
            columns.push(lists(&name(what), reals(numbers), widths()));
        }
    }
    columns.push(whole_numbers("meta/episodes/chunk_index", zeros()));
    columns.push(whole_numbers("meta/episodes/file_index", zeros()));
    write_columns(&dir.join("meta/episodes").join(place(0)), columns, None)
}

/// Where a numbered file lies.
fn place(file: usize) -> String {
    format!("chunk-{:03}/file-{:03}.parquet", file / FILES, file % FILES)
}

fn info(
    fps: u32,
    episodes: &[Episode],
    tasks: usize,
    frames: usize,
    features: &[Feature],
) -> Value {
    let described = features.iter().map(|feature| {
        let text =
            json!({ "dtype": feature.dtype, "shape": [feature.width], "names": feature.names });
        (feature.name.to_string(), text)
    });
    let mut splits = Map::new();
    let mut from = 0;
    for split in SPLITS {
        let to = from
            + episodes
                .iter()
                .filter(|episode| episode.split == split)
                .count();
        if to > from {
            splits.insert(split.name().into(), json!(format!("{from}:{to}")));
        }
        from = to;
    }
    json!({
        "codebase_version": VERSION,
        "robot_type": null,
        "total_episodes": episodes.len(),
        "total_frames": frames,
        "total_tasks": tasks,
        "chunks_size": FILES,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": splits,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": null,
        "features": described.collect::<Map<_, _>>(),
    })
}

fn write_json(path: &Path, value: &Value) -> Result<(), TableError> {
    let mut text = format!("{value:#}");
    text.push('\n');
    Ok(durable::write_bytes(path, text.as_bytes())?)
}

/// A column of a table that is being written.
pub type Column = (Field, ArrayRef);

/// Writes a file, whole or not at all, with an entry of metadata.
pub fn write_columns(
    path: &Path,
    columns: Vec<Column>,
    metadata: Option<(&str, String)>,
) -> Result<(), TableError> {
    let (fields, arrays): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let metadata = metadata.map(|(key, value)| (key.to_string(), value));
    let schema = Arc::new(Schema::new_with_metadata(
        fields,
        metadata.into_iter().collect::<HashMap<_, _>>(),
    ));
    if let Some(folder) = path.parent() {
        durable::create_dir(folder)?;
    }
    let encode = |source: ParquetError| TableError::Encode {
        path: path.to_path_buf(),
        source,
    };
    let batch = RecordBatch::try_new(schema.clone(), arrays)
        .map_err(ParquetError::from)
        .map_err(encode)?;
    let properties = common().build();
    durable::write(path, |file| {
        let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).map_err(encode)?;
        writer.write(&batch).map_err(encode)?;
        writer.close().map(drop).map_err(encode)
    })
}
