//! Whether the object that the camera sees lies at rest, and where.

use std::time::{Duration, Instant};

use values::Point;

/// Distance, in m, from their middle within which the places of an object at rest lie, beyond noise: trackers shift by as much.
const WANDER: f64 = 0.001;
/// Distance allowed on top, in standard deviations of the camera's noise.
const NOISE: f64 = 4.0;
/// Least number of places that show a rest.
const FEWEST: usize = 5;
/// Greatest age of the last place of a rest.
pub(super) const FRESH: Duration = Duration::from_millis(250);
/// Share of the places that may lie elsewhere: outliers of a tracker.
const OUTLIERS: f64 = 0.2;
/// Number of places in a row, at the end, that may not lie elsewhere: those show an object that has just begun to move.
pub(super) const IN_A_ROW: usize = 2;

/// Where the object was seen, and when the message came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: Instant,
    pub(super) point: Point,
    /// Yaw of the object, in rad; none where the topic does not hold it.
    pub(super) yaw: Option<f64>,
    /// Its height in m; none where the topic does not hold it.
    pub(super) z: Option<f64>,
}

/// An object at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resting {
    /// Place of the object, in m.
    pub point: Point,
    /// By how much it is turned, in rad; none where the topic does not hold it.
    pub yaw: Option<f64>,
    /// How high the camera sees it, in m; none where the topic does not hold it.
    pub z: Option<f64>,
}

impl Resting {
    /// A rest at a point, of which no more is known.
    pub fn at(point: Point) -> Self {
        Self {
            point,
            yaw: None,
            z: None,
        }
    }
}

/// Where the object rests, judged by the places since `now - window`, in order of time. `noise` (m) is the camera's. Errors with
/// what is seen in place of a rest.
pub(super) fn resting(
    places: impl Iterator<Item = Place>,
    now: Instant,
    window: Duration,
    noise: f64,
) -> Result<Resting, String> {
    let all: Vec<Place> = places.collect();
    let Some(last) = all.last() else {
        return Err("the camera has not seen it yet".into());
    };
    let age = now.saturating_duration_since(last.at);
    if age > FRESH {
        return Err(format!(
            "the camera has not seen it for {:.1} s",
            age.as_secs_f64()
        ));
    }
    let recent: Vec<Place> = all
        .iter()
        .copied()
        .filter(|place| now.saturating_duration_since(place.at) <= window)
        .collect();
    let is_filled = all
        .iter()
        .any(|place| now.saturating_duration_since(place.at) >= window.mul_f64(0.8));
    if recent.len() < FEWEST || !is_filled {
        return Err(format!(
            "the camera has seen it {} times in the last {:.1} s, which is too short to judge whether it rests",
            recent.len(),
            window.as_secs_f64()
        ));
    }
    let middle = median(&recent);
    let reach = WANDER + NOISE * noise;
    let is_near = |place: &&Place| place.point.distance(middle) <= reach;
    let near: Vec<Place> = recent.iter().filter(is_near).copied().collect();
    let elsewhere = recent.len() - near.len();
    let has_left = !recent
        .iter()
        .rev()
        .take(IN_A_ROW)
        .any(|place| is_near(&place));
    if has_left || elsewhere as f64 > OUTLIERS * recent.len() as f64 {
        let farthest = recent
            .iter()
            .map(|place| place.point.distance(middle))
            .fold(0.0, f64::max);
        return Err(format!(
            "it is seen up to {:.1} mm away from its middle place: it moves, or the camera sees two objects",
            farthest * 1e3
        ));
    }
    let half = near.len() / 2;
    let drift = median(&near[..half]).distance(median(&near[half..]));
    if drift > WANDER + noise {
        return Err(format!("it still moves, by {:.1} mm", drift * 1e3));
    }
    let mean = near
        .iter()
        .fold(Point::default(), |sum, place| sum + place.point)
        * (1.0 / near.len() as f64);
    Ok(Resting {
        point: mean,
        yaw: mean_yaw(&near),
        z: mean_height(&near),
    })
}

/// The median of each coordinate.
fn median(places: &[Place]) -> Point {
    let middle = |coordinate: fn(&Place) -> f64| {
        let mut numbers: Vec<f64> = places.iter().map(coordinate).collect();
        numbers.sort_by(f64::total_cmp);
        numbers.get(numbers.len() / 2).copied().unwrap_or(f64::NAN)
    };
    Point::new(middle(|place| place.point.x), middle(|place| place.point.y))
}

/// The mean height; none where a place has none.
fn mean_height(places: &[Place]) -> Option<f64> {
    let sum = places
        .iter()
        .try_fold(0.0, |sum, place| Some(sum + place.z?));
    sum.map(|sum: f64| sum / places.len() as f64)
}

/// The mean direction; none where a place has none.
fn mean_yaw(places: &[Place]) -> Option<f64> {
    let mut sum = (0.0, 0.0);
    for place in places {
        let (sin, cos) = place.yaw?.sin_cos();
        sum = (sum.0 + sin, sum.1 + cos);
    }
    Some(f64::atan2(sum.0, sum.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Duration = Duration::from_millis(500);
    const NOISE: f64 = 0.0005;

    /// Places at 60 Hz over a second up to now.
    fn seen(at: impl Fn(f64) -> [f64; 2], late: Duration) -> Result<Resting, String> {
        let begun = Instant::now();
        let places = (0..60).map(|frame| {
            let t = f64::from(frame) / 60.0;
            Place {
                at: begun + Duration::from_secs_f64(t),
                point: at(t).into(),
                yaw: None,
                z: None,
            }
        });
        let now = begun + Duration::from_secs(1) + late;
        resting(places, now, WINDOW, NOISE)
    }

    #[test]
    fn an_object_rests_where_it_is_seen_again_and_again() {
        let shaking = |t: f64| [0.3 + 0.0008 * (700.0 * t).sin(), 0.1];
        let rest = seen(shaking, Duration::ZERO).expect("rests");
        assert!(rest.point.distance(Point::new(0.3, 0.1)) < 5e-4, "{rest:?}");
        // An outlier now and then does not matter.
        let outlier = |t: f64| {
            if (t * 60.0) as u32 % 10 == 3 {
                [0.9, 0.9]
            } else {
                [0.3, 0.1]
            }
        };
        assert!(seen(outlier, Duration::ZERO).is_ok());
    }

    #[test]
    fn what_moves_or_is_two_or_is_not_seen_any_more_does_not_rest() {
        let said = |at: fn(f64) -> [f64; 2], late: u64| {
            seen(at, Duration::from_millis(late)).expect_err("no rest")
        };
        assert!(said(|t| [0.3 + 0.01 * t, 0.1], 0).contains("moves"));
        assert!(said(|t| [0.3, 0.1 * f64::from((t * 60.0) as u32 % 2)], 0).contains("two objects"));
        assert!(said(|_| [0.3, 0.1], 400).contains("has not seen it for"));
        assert!(said(|t| [if t < 0.8 { 0.5 } else { 0.3 }, 0.1], 0).contains("moves"));
        let none = resting(std::iter::empty(), Instant::now(), WINDOW, NOISE);
        assert!(none.expect_err("nothing").contains("yet"));
        // Pushed a moment ago, though nearly all places are those of before.
        let pushed = |t: f64| [0.3 + (0.3 * (t - 0.92)).max(0.0), 0.1];
        assert!(
            seen(pushed, Duration::ZERO)
                .expect_err("no rest")
                .contains("moves")
        );
        // Half a second of two frames is too little.
        assert!(said(|_| [f64::NAN, 0.1], 0).contains("mm"));
    }

    #[test]
    fn a_yaw_beyond_the_half_circle_is_one_direction() {
        let now = Instant::now();
        let place = |yaw| Place {
            at: now,
            point: Point::default(),
            yaw: Some(yaw),
            z: None,
        };
        let mean = mean_yaw(&[place(3.1), place(-3.1)]).expect("each has one");
        assert!((mean.abs() - std::f64::consts::PI).abs() < 1e-9);
    }
}
