//! MuJoCo's steps, one strike, one solve, and the planar slides that diagnosis is made of: `cargo bench --profile dev -p world` (the profile that everything is built with).

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use values::{Command, Conditions, Point, Rig, Shape};
use world::{
    Simulator, SolveSettings, World,
    launch::{Launch, launches},
    planar::{self, Deviation, Job, Planar, StrikeInput},
};

/// A cylinder and a box, struck at 0.7 m/s a little to the left; the time of a step is that of a strike over its steps.
fn strikes(criterion: &mut Criterion) {
    let (initial, conditions) = (Point::new(0.3, 0.0), Conditions::default());
    let command = Command {
        speed: 0.7,
        angle: 0.1,
    };
    for (name, shape) in [("cylinder", Shape::Cylinder), ("box", Shape::Box)] {
        let rig = Rig::demo(shape);
        let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("the nominal world");
        let mut worker = simulator.worker();
        let struck = worker.strike(initial, command, &conditions).expect("rests");
        let steps = worker.steps().iter().sum();
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(steps));
        group.bench_function("strike", |bencher| {
            bencher.iter(|| worker.strike(black_box(initial), command, &conditions));
        });
        group.throughput(Throughput::Elements(1));
        group.bench_function("solve", |bencher| {
            let settings = SolveSettings::default();
            bencher.iter(|| {
                worker.solve(
                    black_box(initial),
                    struck.stop,
                    &conditions,
                    &settings,
                    None,
                )
            });
        });
        let world = World::nominal(&rig);
        let launches =
            launches(&rig, &world, [(command, &conditions); 8]).expect("the nominal world");
        let launches: Vec<Launch> = launches.into_iter().flatten().collect();
        let planar = Planar::new(&rig, &world, &[]).expect("the nominal world");
        let times: Vec<f64> = (1..40).map(|i| f64::from(i) / rig.camera.rate).collect();
        let input = StrikeInput {
            initial,
            command,
            conditions: &conditions,
            times: &times,
            to_rest: true,
        };
        let jobs: Vec<Job<'_>> = launches
            .iter()
            .map(|launch| Job {
                planar: &planar,
                input,
                launch,
                deviation: Deviation::default(),
            })
            .collect();
        group.throughput(Throughput::Elements(jobs.len() as u64));
        group.bench_function("planar slides", |bencher| {
            bencher.iter(|| planar::strikes(black_box(&jobs)));
        });
        group.finish();
    }
}

criterion_group!(benches, strikes);
criterion_main!(benches);
