//! A box that does not stand straight.

use rig::{Hidden, Hide, Sim, Truth};
use store::Model;
use strike::Planner;
use values::{Conditions, Point, Rig, Shape};
use world::{Simulator, World};

use crate::fixture::{self, FROM};

const TO: Point = Point { x: 0.6, y: 0.08 };

fn world() -> World {
    let world = World::nominal().with("friction", 0.18);
    world.with("restitution", 0.5).with("tip_friction", 0.7)
}

fn planner() -> Planner {
    let mut artifact = fixture::artifact();
    artifact.rig = Rig::demo(Shape::Box);
    artifact.sysid.world = world();
    Planner::new(&artifact, Model::Sysid).unwrap()
}

#[test]
fn is_struck_where_it_stands() {
    let planner = planner();
    let simulator = Simulator::new(&Rig::demo(Shape::Box), &world()).unwrap();
    let straight = planner.plan(FROM, TO).unwrap();
    assert_eq!(straight.yaw, None);
    assert!(!serde_json::to_string(&straight).unwrap().contains("yaw"));
    for yaw in [-0.15, 0.1] {
        let plan = planner.plan_turned(FROM, TO, yaw).unwrap();
        assert_eq!(plan.yaw, Some(yaw));
        let conditions = Conditions {
            yaw: Some(yaw),
            ..Conditions::default()
        };
        let mut worker = simulator.worker();
        let mut stop = |command| worker.strike(FROM, command, &conditions).unwrap().stop;
        assert!(stop(plan.command()).distance(TO) < 1e-3);
        assert!(stop(straight.command()).distance(TO) > 3e-3);
        // The tip touches the face that is turned.
        let standoff = |plan: &strike::Plan| plan.strike.distance(FROM);
        assert!((standoff(&plan) - standoff(&straight)).abs() > 1e-4);
    }
}

#[test]
fn is_missed_by_far_less_than_where_its_yaw_is_not_looked_at() {
    let planner = planner();
    let mut truth = Truth::demo(&Rig::demo(Shape::Box), 5);
    truth.hidden = Hidden::none();
    truth.noise = Hide::parse(&["yaw_scatter"]).unwrap().noise;
    (truth.scatter.speed, truth.scatter.angle) = (0.0, 0.0);
    let miss = |uses_yaw: bool| {
        let mut sim = Sim::from(truth.clone()).unwrap();
        let strikes = 40;
        let sum: f64 = (0..strikes)
            .map(|_| {
                let yaw = sim.next_yaw(FROM).filter(|_| uses_yaw);
                let plan = planner.plan_turned(FROM, TO, yaw.unwrap_or(0.0)).unwrap();
                sim.strike(FROM, plan.command()).stop.distance(TO)
            })
            .sum();
        sum / f64::from(strikes)
    };
    let (used, ignored) = (miss(true), miss(false));
    println!("used {used:.5} m, not looked at {ignored:.5} m");
    assert!(used < 0.5 * ignored, "{used} {ignored}");
}
