//! Whether the object still lies as it was seen at rest: by many places before a strike, by each message while the tip runs up to it.

use std::fmt;
use std::time::{Duration, Instant};

use values::Rig;

use super::rest::{IN_A_ROW, Resting};

/// Distance, in m, from its place beyond which an object was moved.
const MOVED: f64 = 0.003;
/// Turn, in rad, beyond which an object was moved.
const TURNED: f64 = 0.05;
/// Least height, in m, by which a lifted object is seen higher, however flat it is: by less a camera's frame may lean.
const LIFTED: f64 = 0.01;
/// Greatest error of a single message: of a place, in standard deviations of the camera's noise, and of a yaw, in rad.
const ALONE: (f64, f64) = (4.0, 0.15);
/// Time without a message that shows the object after which it counts as covered by a hand, or taken: three frames of 30 Hz.
const BLIND: Duration = Duration::from_millis(100);

/// Least height (m) above its place of an object that somebody has lifted.
pub(super) fn lifted(rig: &Rig) -> f64 {
    rig.object.solid.half_height().max(LIFTED)
}

/// Whether an object at rest lies as it did before, within the camera's noise and 3 mm, and what is not round within 3°. Errors with what
/// differs.
pub(super) fn as_before(rig: &Rig, before: &Resting, now: &Resting) -> Result<(), String> {
    let most = (MOVED + rig.camera.noise, TURNED);
    differs(rig, before, now, most).map_or(Ok(()), Err)
}

/// What differs by more than `far` (m) or `wide` (rad), in words; none where nothing does.
fn differs(rig: &Rig, before: &Resting, now: &Resting, (far, wide): (f64, f64)) -> Option<String> {
    let place = before.point;
    let moved = now.point.distance(place);
    if moved > far {
        return Some(format!(
            "it has moved by {:.1} mm since it was seen at ({:.4}, {:.4}) m",
            moved * 1e3,
            place.x,
            place.y
        ));
    }
    if let Some((now, before)) = now.z.zip(before.z)
        && (now - before).abs() > lifted(rig)
    {
        let way = if now > before { "higher" } else { "lower" };
        return Some(format!(
            "it is {:.1} mm {way} than it was seen at rest",
            (now - before).abs() * 1e3
        ));
    }
    let period = rig.object.solid.period();
    let (period, (now, before)) = period.zip(now.yaw.zip(before.yaw))?;
    let turned = now - before - ((now - before) / period).round() * period;
    (turned.abs() > wide)
        .then(|| format!("it was turned by {turned:.3} rad since it was seen at rest"))
}

/// Called with the time of a message that must end the strike, and what it showed.
type Ends = Box<dyn FnMut(Instant, &str) + Send>;

/// Looks at each message of the camera while the tip runs up to the object.
pub(super) struct Sentry {
    rig: Rig,
    before: Resting,
    in_a_row: usize,
    last: Instant,
    ends: Ends,
}

impl Sentry {
    /// A watch on an object that was seen at rest.
    pub(super) fn new(
        rig: &Rig,
        before: Resting,
        ends: impl FnMut(Instant, &str) + Send + 'static,
    ) -> Self {
        Self {
            rig: rig.clone(),
            before,
            in_a_row: 0,
            last: Instant::now(),
            ends: Box::new(ends),
        }
    }

    /// Judges what a message shows that came at a moment.
    pub(super) fn sees(&mut self, at: Instant, now: &Resting) {
        self.last = at;
        let (noises, turned) = ALONE;
        let most = (MOVED + noises * self.rig.camera.noise, turned);
        let moved = differs(&self.rig, &self.before, now, most);
        self.in_a_row = moved.as_ref().map_or(0, |_| self.in_a_row + 1);
        if let Some(how) = moved.filter(|_| self.in_a_row >= IN_A_ROW) {
            (self.ends)(
                at,
                &format!("the object was moved during the run-up: {how}"),
            );
        }
    }

    /// Notes that no message has shown the object up to a moment.
    pub(super) fn waits(&mut self, now: Instant) {
        let unseen = now.saturating_duration_since(self.last);
        if unseen > BLIND {
            self.is_blind(now, &format!("for {} ms", unseen.as_millis()));
        }
    }

    /// Notes that the object is seen no more, for a reason that lasts.
    pub(super) fn is_blind(&mut self, at: Instant, why: &str) {
        (self.ends)(
            at,
            &format!("the object was seen no more during the run-up: {why}"),
        );
    }
}

impl fmt::Debug for Sentry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Sentry")
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use std::f64::consts::PI;

    use values::{Point, Shape};

    use super::*;

    #[test]
    fn an_object_that_is_moved_is_told_by_its_second_message_and_an_outlier_is_not() {
        let (rig, before) = (
            Rig::demo(Shape::Cylinder),
            Resting::at(Point::new(0.3, 0.0)),
        );
        let told = |seen: &[f64]| -> Vec<String> {
            let (tell, told) = mpsc::channel();
            let mut sentry = Sentry::new(&rig, before, move |_, how| {
                tell.send(how.to_owned()).expect("is heard");
            });
            for mm in seen {
                let now = Resting::at(Point::new(0.3 + mm * 1e-3, 0.0));
                sentry.sees(Instant::now(), &now);
            }
            drop(sentry);
            told.iter().collect()
        };
        // The demo's noise is 0.7 mm.
        assert!(told(&[5.0; 20]).is_empty());
        assert!(told(&[200.0, 0.0, 200.0, 0.0]).is_empty());
        let said = told(&[0.0, 4.0, 9.0, 14.0, 19.0]);
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].contains("moved by 14.0 mm"), "{said:?}");
    }

    #[test]
    fn an_object_that_no_message_shows_any_more_is_told() {
        let (tell, told) = mpsc::channel();
        let rig = Rig::demo(Shape::Cylinder);
        let before = Resting::at(Point::new(0.3, 0.0));
        let mut sentry = Sentry::new(&rig, before, move |_, how| {
            tell.send(how.to_owned()).expect("is heard");
        });
        let begun = Instant::now();
        let at = |ms: u64| begun + Duration::from_millis(ms);
        sentry.sees(at(1_000), &before);
        // Two of 30 frames a second were lost.
        sentry.waits(at(1_100));
        assert!(told.try_recv().is_err());
        sentry.waits(at(1_140));
        assert!(told.recv().expect("told").contains("seen no more"));
    }

    #[test]
    fn an_object_that_is_lifted_or_turned_is_not_as_it_was() {
        let (cylinder, cuboid) = (Rig::demo(Shape::Cylinder), Rig::demo(Shape::Box));
        let seen = |z, yaw| Resting {
            point: Point::new(0.3, 0.0),
            yaw,
            z,
        };
        // Half of the demo's 40 mm.
        for (before, now, said) in [
            (Some(0.0), Some(0.019), ""),
            (Some(0.0), Some(0.021), "21.0 mm higher"),
            (Some(0.8), Some(0.77), "30.0 mm lower"),
            (Some(0.8), Some(0.8), ""),
            (None, Some(0.3), ""),
            (Some(0.3), None, ""),
        ] {
            let why = as_before(&cylinder, &seen(before, None), &seen(now, None));
            let why = why.err().unwrap_or_default();
            assert_eq!(why.is_empty(), said.is_empty(), "{why}");
            assert!(why.contains(said), "{why}");
        }
        let turned =
            |rig: &Rig, yaw| as_before(rig, &seen(None, Some(0.0)), &seen(None, Some(yaw)));
        assert!(turned(&cuboid, 0.06).is_err() && turned(&cuboid, 0.04).is_ok());
        assert!(turned(&cuboid, PI).is_ok() && turned(&cylinder, 0.06).is_ok());
    }
}
