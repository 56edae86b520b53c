//! Frames for `make bench PARTS=track`: renders them, and measures carom on them as `tests/peers/opencv.py` measures OpenCV.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::{Parser, Subcommand, ValueEnum};
use logs::read::{RawMessage, read_raw};
use logs::write::CopyWriter;
use logs::{Limits, LogError};
use rayon::prelude::*;
use render::case::{self, Case};
use render::hostile::{KINDS, Kind};
use render::{Moment, Optics, Renderer, Scene};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use track::{
    Decoder, FrameReport, ImageMessage, Observation, Payload, QUALITY_TOPIC, Tracker, track_log,
};
use values::{Rig, Shape};

#[derive(Debug, Parser)]
struct Args {
    #[command(subcommand)]
    part: Part,
}

#[derive(Debug, Subcommand)]
enum Part {
    /// Renders so many frames of a case into a folder, with the truth and the rig beside them.
    Render {
        dir: PathBuf,
        case: Name,
        width: usize,
        height: usize,
        count: usize,
    },
    /// Renders scenes that should not be trusted into a folder: so many of each kind, from this number on.
    Hostile {
        dir: PathBuf,
        shape: String,
        first: usize,
        count: usize,
    },
    /// Writes a log of a folder's frames, again and again up to so many bytes, and its rig file.
    Log {
        dir: PathBuf,
        log: PathBuf,
        rig: PathBuf,
        bytes: u64,
    },
    /// Tracks a log and takes the strikes from it: what is said of every frame, and the strikes that are kept.
    Strikes {
        log: PathBuf,
        rig: PathBuf,
        out: PathBuf,
    },
    /// Finds the object in a folder's frames, so many times over.
    Track {
        dir: PathBuf,
        threads: usize,
        rounds: usize,
    },
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    Clean,
    Noise,
    Gradient,
    Shadow,
    Blur,
    /// All at once with JPEG and lens, a flat disc.
    All,
    /// Clean frames of an object 40 mm tall.
    Tall,
}

#[derive(Clone, Serialize, Deserialize)]
struct Frame {
    file: String,
    /// Centroid of what is seen of the object, in px; none where it is not seen.
    pixel: Option<[f64; 2]>,
    /// The object's centre on the table in m.
    place: [f64; 2],
    /// Share of its picture that nothing hides or cuts off.
    seen: f64,
}

/// The square of this many rays is cast for a pixel.
const RAYS: usize = 6;
/// Px around an image within which an object that its border cuts is whole.
const AROUND: usize = 64;

fn main() -> anyhow::Result<()> {
    let answer = match Args::parse().part {
        Part::Render {
            dir,
            case,
            width,
            height,
            count,
        } => render(&dir, case, [width, height], count)?,
        Part::Hostile {
            dir,
            shape,
            first,
            count,
        } => hostile(&dir, &shape, first, count)?,
        Part::Log {
            dir,
            log,
            rig,
            bytes,
        } => write_log(&dir, &log, &rig, bytes)?,
        Part::Strikes { log, rig, out } => strikes(&log, &rig, &out)?,
        Part::Track {
            dir,
            threads,
            rounds,
        } => track(&dir, threads, rounds)?,
    };
    println!("{answer}");
    Ok(())
}

fn render(dir: &Path, name: Name, pixels: [usize; 2], count: usize) -> anyhow::Result<Value> {
    let flat = Case::flat();
    let (case, object) = match name {
        Name::Clean => (Case { noise: 0.0, ..flat }, case::disc()),
        Name::Noise => (flat, case::disc()),
        Name::Gradient => (
            Case {
                scene: case::gradient,
                ..flat
            },
            case::disc(),
        ),
        Name::Shadow => (
            Case {
                scene: case::shadow,
                ..flat
            },
            case::disc(),
        ),
        Name::Blur => (
            Case {
                speed: 1.0,
                exposure: 0.005,
                ..flat
            },
            case::disc(),
        ),
        Name::All => (Case::all(), case::disc()),
        Name::Tall => (Case::all(), case::tall(Shape::Cylinder)),
    };
    let case = Case { pixels, ..case };
    let rig = case::rig(&object, &case);
    let mut scene = Scene::plain(&rig.object).context("a size is missing")?;
    (case.scene)(&mut scene);
    let optics = Optics::of(&rig, pixels).context("no camera")?;
    let renderer = Renderer::new(optics, scene, case.noise, RAYS);
    fs::create_dir_all(dir)?;
    let render = |(index, (at, heading)): (usize, (Moment, f64))| -> anyhow::Result<Frame> {
        let (sin, cos) = heading.sin_cos();
        let path = |time: f64| Moment {
            x: at.x + case.speed * time * cos,
            y: at.y + case.speed * time * sin,
            yaw: at.yaw,
        };
        let rendered = renderer.render(&path, index as u64);
        let (data, end) = match case.jpeg {
            Some(quality) => (rendered.picture.jpeg(quality)?, "jpg"),
            None => (rendered.picture.png()?, "png"),
        };
        let file = format!("{index:04}.{end}");
        fs::write(dir.join(&file), data)?;
        Ok(Frame {
            file,
            pixel: rendered.centroid,
            place: [at.x, at.y],
            seen: 1.0,
        })
    };
    let places: Vec<_> = case::places(count).into_iter().enumerate().collect();
    let frames = places.into_par_iter().map(render);
    let frames = frames.collect::<anyhow::Result<Vec<_>>>()?;
    keep(dir, &frames, &rig)
}

fn keep(dir: &Path, frames: &[Frame], rig: &Rig) -> anyhow::Result<Value> {
    fs::write(dir.join("truth.json"), serde_json::to_vec(frames)?)?;
    fs::write(dir.join("rig.json"), serde_json::to_vec(rig)?)?;
    Ok(json!({ "frames": frames.len() }))
}

fn hostile(dir: &Path, shape: &str, first: usize, count: usize) -> anyhow::Result<Value> {
    let case = Case {
        pixels: [640, 480],
        ..Case::flat()
    };
    let shapes = [Shape::Cylinder, Shape::Box, Shape::Sphere];
    let shape = shapes.into_iter().find(|known| known.name() == shape);
    let rig = case::rig(&case::tall(shape.context("no such shape")?), &case);
    let plain = Scene::laboratory(&rig.object).context("a size is missing")?;
    let optics = Optics::of(&rig, case.pixels).context("no camera")?;
    let renderer = Renderer::new(optics, plain.clone(), case.noise, RAYS);
    // The same camera with a larger image, in which nothing is cut off.
    let mut around = rig.clone();
    if let Some([_, _, x, y]) = &mut around.camera.matrix {
        (*x, *y) = (*x + AROUND as f64, *y + AROUND as f64);
    }
    let pixels = case.pixels.map(|size| size + 2 * AROUND);
    let whole = Optics::of(&around, pixels).context("no camera")?;
    let whole = Renderer::new(whole, plain.clone(), 0.0, 2);
    fs::create_dir_all(dir)?;
    let kinds = KINDS.iter().enumerate().collect::<Vec<_>>();
    let of_kind = |(which, kind): (usize, &Kind)| -> anyhow::Result<Vec<Frame>> {
        let mut renderer = renderer.clone();
        let mut frames = Vec::with_capacity(count);
        for number in first + which * count..first + (which + 1) * count {
            let (scene, at) = kind.scene(&plain, number);
            renderer.set_scene(scene);
            let rendered = renderer.render(&|_| at, number as u64);
            let file = format!("{which}_{number:06}.jpg");
            fs::write(dir.join(&file), rendered.picture.jpeg(90)?)?;
            let area = whole.render(&|_| at, 0).area;
            frames.push(Frame {
                file,
                pixel: rendered.centroid,
                place: [at.x, at.y],
                seen: rendered.area / area.max(1.0),
            });
        }
        Ok(frames)
    };
    let frames = kinds.into_par_iter().map(of_kind);
    let frames = frames.collect::<anyhow::Result<Vec<_>>>()?;
    keep(dir, &frames.concat(), &rig)
}

fn write_log(dir: &Path, log: &Path, rig_file: &Path, bytes: u64) -> anyhow::Result<Value> {
    /// Of a camera of 60 frames a second, in ns.
    const PERIOD: u64 = 16_666_667;
    let frames: Vec<Frame> = serde_json::from_slice(&fs::read(dir.join("truth.json"))?)?;
    let rig: Rig = serde_json::from_slice(&fs::read(dir.join("rig.json"))?)?;
    let topic = rig.topics.image.as_ref().context("no topic")?;
    let files = frames.iter().map(|frame| fs::read(dir.join(&frame.file)));
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let mut writer = CopyWriter::create(log)?;
    let (mut written, mut stamp) = (0, 1_700_000_000_000_000_000);
    for file in files.iter().cycle() {
        writer.jpeg(&topic.name, stamp, stamp, file)?;
        written += file.len() as u64;
        stamp += PERIOD;
        if written >= bytes {
            break;
        }
    }
    writer.finish()?;
    fs::write(rig_file, rig.to_toml())?;
    Ok(json!({ "bytes": written }))
}

fn strikes(log: &Path, rig: &Path, out: &Path) -> anyhow::Result<Value> {
    let rig = Rig::load(rig)?;
    let outcome = track_log(log, &rig, out, None)?;
    let mut reports = Vec::new();
    read_raw(out, Limits::default(), &mut |message: RawMessage<'_>| {
        if message.channel.topic == QUALITY_TOPIC {
            reports.extend(serde_json::from_slice::<FrameReport>(message.data));
        }
        Ok::<_, LogError>(())
    })?;
    let found = ingest::ingest_log(out, &rig, &ingest::Ingest { seed: 0 })?;
    let kept = found.strikes.iter().map(|strike| {
        json!({ "t": strike.t_start, "start": [strike.initial.x, strike.initial.y], "stop": [strike.stop.x, strike.stop.y] })
    });
    let rejects = found.rejects.iter();
    let rejects = rejects.map(|reject| json!({ "t": reject.t_start, "why": reject.detail }));
    Ok(json!({
        "outcome": outcome, "frames": reports, "strikes": kept.collect::<Vec<_>>(), "rejects": rejects.collect::<Vec<_>>(),
    }))
}

fn track(dir: &Path, threads: usize, rounds: usize) -> anyhow::Result<Value> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()?;
    let frames: Vec<Frame> = serde_json::from_slice(&fs::read(dir.join("truth.json"))?)?;
    let rig: Rig = serde_json::from_slice(&fs::read(dir.join("rig.json"))?)?;
    let files = frames.iter().map(|frame| fs::read(dir.join(&frame.file)));
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let tracker = Tracker::new(&rig)?;
    let all: Vec<&Vec<u8>> = (0..rounds).flat_map(|_| &files).collect();
    // Each thread takes the next image, as those of a log do.
    let next = AtomicUsize::new(0);
    let observe = |_: rayon::BroadcastContext<'_>| -> anyhow::Result<Vec<(usize, Observation)>> {
        let (mut decoder, mut seen) = (Decoder::default(), Vec::new());
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(data) = all.get(index) else {
                return Ok(seen);
            };
            let payload = Payload::Compressed(data);
            let image = decoder.decode(&ImageMessage { stamp: 0, payload })?;
            seen.push((index, tracker.observe(image)));
        }
    };
    let begun = Instant::now();
    let seen = rayon::broadcast(observe);
    let seconds = begun.elapsed().as_secs_f64();
    let seen = seen.into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    let mut seen = seen.concat();
    seen.sort_by_key(|(index, _)| *index);
    let found: Vec<_> = seen
        .iter()
        .take(files.len())
        .map(|(_, seen)| {
            let place = seen.centre.ok().map(|centre| [centre.x, centre.y]);
            place.and(seen.pixel).zip(place)
        })
        .collect();
    if found.is_empty() {
        bail!("no frames in {}", dir.display());
    }
    let said = seen.iter().take(files.len());
    let said = said.map(|(_, seen)| json!({ "reason": seen.centre.err(), "deviation": seen.deviation, "quality": seen.quality }));
    let said = said.collect::<Vec<_>>();
    Ok(json!({ "seconds": seconds, "frames": all.len(), "found": found, "said": said }))
}
