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
    type Change<'a> = Box<dyn Fn(&mut Rig) + 'a>;
    // Just stricter than what the usual plan needs.
    let cases: Vec<(&str, Change<'_>, Reason)> = vec![
        (
            "table.x from below",
            Box::new(|rig| rig.table.x.low = FROM.x - 0.029),
            Reason::OffTable,
        ),
        (
            "table.x from above",
            Box::new(|rig| rig.table.x.high = TO.x + 0.029),
            Reason::OffTable,
        ),
        (
            "table.y from below",
            Box::new(|rig| rig.table.y.low = FROM.y - 0.029),
            Reason::OffTable,
        ),
        (
            "table.y from above",
            Box::new(|rig| rig.table.y.high = TO.y + 0.029),
            Reason::OffTable,
        ),
        (
            "speed from below",
            Box::new(|rig| rig.robot.speed.low = speed + 1e-3),
            Reason::SpeedLimit,
        ),
        (
            "speed from above",
            Box::new(|rig| rig.robot.speed.high = speed - 1e-3),
            Reason::SpeedLimit,
        ),
        (
            "angle from below",
            Box::new(|rig| rig.robot.angle.low = angle + 1e-3),
            Reason::AngleLimit,
        ),
        (
            "angle from above",
            Box::new(|rig| rig.robot.angle.high = angle - 1e-3),
            Reason::AngleLimit,
        ),
        (
            "acceleration",
            Box::new(|rig| rig.robot.acceleration = 1.0),
            Reason::KeepOut,
        ),
        (
            "jerk",
            Box::new(|rig| rig.robot.jerk = Some(3.0)),
            Reason::Reach,
        ),
        (
            "keep_out",
            Box::new(|rig| rig.robot.keep_out = Some(nearest - rig.striker.radius + 1e-3)),
            Reason::KeepOut,
        ),
        (
            "reach from below",
            Box::new(|rig| rig.robot.reach = Some([nearest + 1e-3, 1.2].into())),
            Reason::Reach,
        ),
        (
            "reach from above",
            Box::new(|rig| rig.robot.reach = Some([0.1, farthest - 1e-3].into())),
            Reason::Reach,
        ),
        (
            "base",
            Box::new(|rig| rig.robot.base = Some(usual.start)),
            Reason::KeepOut,
        ),
        (
            "obstacles",
            Box::new(|rig| {
                rig.robot.obstacles = vec![Obstacle::Disc {
                    centre: usual.start,
                    radius: 0.01,
                }];
            }),
            Reason::Obstacle,
        ),
    ];
    for (name, change, reason) in cases {
        let answer = within(|rig| change(rig));
        let refusal = answer.err().unwrap_or_else(|| panic!("{name} is planned"));
        assert_eq!(refusal.refused, reason, "{name}: {refusal}");
    }
}
