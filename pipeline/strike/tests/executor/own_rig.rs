//! Each limit of a robot's own rig file counts, alone and in its own direction.

use store::Model;
use strike::{Plan, Planner, Reason, Refusal};
use values::{Obstacle, Point, Rig};

use crate::fixture::{self, FROM, TO};

/// The plan of an arm that says where it stands, within a rig file that differs by one key.
fn within(change: impl FnOnce(&mut Rig)) -> Result<Plan, Refusal> {
    let artifact = fixture::artifact();
    let mut own = artifact.rig.clone();
    own.robot.base = Some(Point::new(-0.1, 0.0));
    own.robot.keep_out = Some(0.1);
    own.robot.reach = Some([0.1, 1.2].into());
    change(&mut own);
    strike::identity::check(&artifact.rig, &own).unwrap();
    let planner = Planner::within(&artifact, Model::Sysid, &own).unwrap();
    planner.plan(FROM, TO)
}

#[test]
fn every_limit_counts_alone() {
    let usual = within(|_| ()).unwrap();
    let base = Point::new(-0.1, 0.0);
    let nearest = usual.start.distance(base);
    let farthest = usual.stop.distance(base);
    let (speed, angle) = (usual.speed, usual.angle);
    type Change<'a> = (&'a str, Reason, &'a dyn Fn(&mut Rig));
    // Just stricter than what the usual plan needs.
    let cases: [Change<'_>; 15] = [
        ("table.x from below", Reason::OffTable, &|rig| {
            rig.table.x.low = FROM.x - 0.029
        }),
        ("table.x from above", Reason::OffTable, &|rig| {
            rig.table.x.high = TO.x + 0.029
        }),
        ("table.y from below", Reason::OffTable, &|rig| {
            rig.table.y.low = FROM.y - 0.029
        }),
        ("table.y from above", Reason::OffTable, &|rig| {
            rig.table.y.high = TO.y + 0.029
        }),
        ("speed from below", Reason::SpeedLimit, &|rig| {
            rig.robot.speed.low = speed + 1e-3
        }),
        ("speed from above", Reason::SpeedLimit, &|rig| {
            rig.robot.speed.high = speed - 1e-3
        }),
        ("angle from below", Reason::AngleLimit, &|rig| {
            rig.robot.angle.low = angle + 1e-3
        }),
        ("angle from above", Reason::AngleLimit, &|rig| {
            rig.robot.angle.high = angle - 1e-3
        }),
        ("acceleration", Reason::KeepOut, &|rig| {
            rig.robot.acceleration = 1.0
        }),
        ("jerk", Reason::Reach, &|rig| rig.robot.jerk = Some(3.0)),
        ("keep_out", Reason::KeepOut, &|rig| {
            rig.robot.keep_out = Some(nearest - rig.striker.radius + 1e-3)
        }),
        ("reach from below", Reason::Reach, &|rig| {
            rig.robot.reach = Some([nearest + 1e-3, 1.2].into())
        }),
        ("reach from above", Reason::Reach, &|rig| {
            rig.robot.reach = Some([0.1, farthest - 1e-3].into())
        }),
        ("base", Reason::KeepOut, &|rig| {
            rig.robot.base = Some(usual.start)
        }),
        ("obstacles", Reason::Obstacle, &|rig| {
            rig.robot.obstacles = vec![Obstacle::Disc {
                centre: usual.start,
                radius: 0.01,
            }];
        }),
    ];
    for (name, reason, change) in cases {
        let answer = within(change);
        let refusal = answer.err().unwrap_or_else(|| panic!("{name} is planned"));
        assert_eq!(refusal.refused, reason, "{name}: {refusal}");
    }
}
