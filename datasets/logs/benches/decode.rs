//! From the bytes of a log to samples: `cargo bench --profile dev -p logs` (the profile that everything is built with).

use std::hint::black_box;
use std::io::Cursor;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use logs::write::{RecordingWriter, Samples, Stamped};
use logs::{Limits, TopicRequest, read_from};
use values::Topics;

/// Two minutes of a log: centroids at 60 Hz, commands at 250 Hz.
fn log(topics: &Topics) -> (Vec<u8>, u64) {
    let series = |rate: u64| -> Vec<Stamped> {
        (0..120 * rate)
            .map(|i| Stamped {
                stamp: 1_700_000_000_000_000_000 + i * 1_000_000_000 / rate,
                x: 0.3 + (i as f64).sin(),
                y: 0.1 * (i as f64).cos(),
            })
            .collect()
    };
    let samples = Samples {
        centroids: series(60),
        commands: series(250),
        states: Vec::new(),
    };
    let messages = samples.centroids.len() + samples.commands.len();
    let mut writer = RecordingWriter::new(Cursor::new(Vec::new()), topics).expect("a log");
    writer.write(&samples).expect("written to memory");
    let bytes = writer.finish().expect("written to memory").into_inner();
    (bytes, messages as u64)
}

fn decode(criterion: &mut Criterion) {
    let topics = Topics::default();
    let (bytes, messages) = log(&topics);
    let wanted = [&topics.centroid, &topics.command].map(|topic| TopicRequest {
        topic,
        more: &[],
        required: true,
    });
    let mut group = criterion.benchmark_group("decode");
    group.throughput(Throughput::Elements(messages));
    group.bench_function("cdr", |bencher| {
        bencher.iter(|| {
            let mut seen = 0;
            let source = Cursor::new(black_box(&bytes));
            read_from("memory", source, &wanted, Limits::default(), &mut |_| {
                seen += 1
            })
            .expect("a whole log");
            assert_eq!(seen, messages);
        });
    });
    group.finish();
}

criterion_group!(benches, decode);
criterion_main!(benches);
