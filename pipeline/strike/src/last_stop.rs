//! Where an arm's last strike left the object, kept by the arm's serial number and not by folder of logs: whichever call strikes next, and
//! whatever became of the logs, an object that nobody put back is not struck.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{env, fs, io};

use values::Point;

use crate::robot::arm::Height;

/// An object that was put back lies farther than this, in m, from where it stopped.
const PUT_BACK: f64 = 0.02;

/// Where the last strike left the object. There it must not be struck again: nobody has put it back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LastStop {
    None,
    /// The object was seen to stop here, in m.
    At(Point),
    /// The object was not seen to stop. The place where it is seen at rest next, in m once it was, may be where it stopped.
    Unseen(Option<Point>),
}

/// Nowhere to keep where an arm's last strike left the object.
#[derive(Debug, thiserror::Error)]
#[error(
    "find a folder for where the object stopped last: neither XDG_STATE_HOME nor HOME is an absolute path; set one"
)]
pub struct NoMemory;

/// The last stop, and the file that holds it.
#[derive(Debug)]
pub struct Memory {
    path: PathBuf,
    stop: LastStop,
    /// When, in s since 1970, a strike was begun whose record was not written, or reported as lost, yet.
    begun: Option<u64>,
    /// When, in s since 1970, an earlier program began a strike and kept no record of it; none once a person was told.
    lost: Option<u64>,
    /// Where a strike that was not ended left the tip, or will have if this program is killed in it; none after one that was ended.
    left: Option<Height>,
}

/// The folder of what is kept by arm: `carom` in XDG_STATE_HOME, or in `.local/state` of the user's home. Errors where neither is set
/// to an absolute path.
pub fn memory_folder() -> Result<PathBuf, NoMemory> {
    folder_by(|name| env::var_os(name))
}

/// The folder of what is kept by arm, by these environment variables. Errors where neither is an absolute path: a relative one would be another
/// folder for each call.
fn folder_by(variable: impl Fn(&str) -> Option<OsString>) -> Result<PathBuf, NoMemory> {
    let set = |name: &str| {
        variable(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    set("XDG_STATE_HOME")
        .or_else(|| Some(set("HOME")?.join(".local/state")))
        .map(|state| state.join("carom"))
        .ok_or(NoMemory)
}

impl Memory {
    /// Opens what is kept of an arm, by its serial number. A file that cannot be understood counts as saying that an object may lie where it stopped.
    pub fn open(folder: &Path, serial: &str) -> Result<Self, durable::Error> {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name: String = serial.chars().map(plain).take(100).collect();
        let path = folder.join(format!("stop_of_{name}"));
        let unknown = (LastStop::Unseen(None), None, None);
        let (stop, lost, left) = match fs::read_to_string(&path) {
            Ok(text) => parse(&text).unwrap_or(unknown),
            Err(error) if error.kind() == io::ErrorKind::NotFound => (LastStop::None, None, None),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => unknown,
            Err(error) => return Err(durable::Error::new("read", &path, error)),
        };
        Ok(Self {
            path,
            stop,
            begun: lost,
            lost,
            left,
        })
    }

    /// The warning for a person of a strike that an earlier program began and kept no record of; once.
    pub fn lost(&mut self) -> Option<String> {
        let begun = UNIX_EPOCH + Duration::from_secs(self.lost.take()?);
        let ago = SystemTime::now().duration_since(begun);
        let ago = match ago.unwrap_or_default().as_secs() {
            seconds @ 0..100 => format!("{seconds} s"),
            seconds => format!("{} min", seconds / 60),
        };
        Some(format!(
            "a strike of this arm was begun {ago} ago and no record of it was written: the program was killed, or the computer stopped. \
             The object may lie elsewhere than before, the arm may stand low beside it: look at both"
        ))
    }

    /// Notes that a strike begins at this height (m): whatever ends this program before its record is written is told by the next one.
    pub(crate) fn begin(&mut self, height: Height) -> Result<(), durable::Error> {
        self.left = Some(height);
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        self.begun = Some(now.unwrap_or_default().as_secs());
        self.keep(LastStop::Unseen(None))
    }

    /// Notes that the strike's record was written, or that a person was told that it was not.
    pub fn recorded(&mut self) {
        if self.begun.take().is_some() {
            // What cannot be kept is told once more.
            let _ = self.keep(self.stop);
        }
    }

    /// Where a strike that was not ended left the tip.
    pub(crate) fn left(&self) -> Option<Height> {
        self.left
    }

    /// Sets where a strike that was not ended left the tip; written to the disk with the next stop.
    pub(crate) fn left_at(&mut self, left: Option<Height>) {
        self.left = left;
    }

    pub(crate) fn stop(&self) -> LastStop {
        self.stop
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Keeps a stop, on the disk too. Where that fails, the disk holds what it held.
    pub(crate) fn keep(&mut self, stop: LastStop) -> Result<(), durable::Error> {
        self.stop = stop;
        let mut text = match stop {
            LastStop::None if self.begun.is_none() && self.left.is_none() => {
                return match fs::remove_file(&self.path) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => {
                        Err(durable::Error::new("remove", &self.path, error))
                    }
                    _ => Ok(()),
                };
            }
            LastStop::None => "none\n".into(),
            LastStop::At(at) => format!("{:.4} {:.4}\n", at.x, at.y),
            LastStop::Unseen(None) => "unseen\n".into(),
            LastStop::Unseen(Some(at)) => format!("unseen {:.4} {:.4}\n", at.x, at.y),
        };
        if let Some(begun) = self.begun {
            text += &format!("begun {begun}\n");
        }
        if let Some(Height { above, z }) = self.left {
            text += &format!("left {above:.4} {z:.4}\n");
        }
        if let Some(folder) = self.path.parent() {
            durable::create_dir(folder)?;
        }
        durable::write_bytes(&self.path, text.as_bytes())
    }

    /// Whether the object lies where its last strike left it, or may have: from there on it is followed, for what creeps away by itself, as on
    /// a table that leans, was put nowhere.
    pub(crate) fn is_at(&mut self, place: Point) -> bool {
        match &mut self.stop {
            LastStop::None => false,
            LastStop::At(stop) | LastStop::Unseen(Some(stop)) => {
                let is_there = stop.distance(place) < PUT_BACK;
                if is_there {
                    *stop = place;
                }
                is_there
            }
            LastStop::Unseen(stop @ None) => {
                *stop = Some(place);
                true
            }
        }
    }

    /// Whether one strike that a person calls for may be made where the object is seen at rest: anywhere once it was seen to stop; else not
    /// where it may have stopped, which is kept. Errors with why not.
    pub fn permits(&mut self, place: Point) -> Result<(), String> {
        if matches!(self.stop, LastStop::At(_)) || !self.is_at(place) {
            return Ok(());
        }
        // What cannot be kept is asked for once more.
        let _ = self.keep(self.stop);
        Err(format!(
            "this arm's last strike was not seen to its end: where the object lies now that strike may have left it. Put it 2 cm or more \
             from ({:.3}, {:.3}) m and call again (as {} says)",
            place.x,
            place.y,
            self.path.display()
        ))
    }
}

/// The last stop, when a strike was begun that has no record, and how high one that was not ended left the tip.
fn parse(text: &str) -> Option<(LastStop, Option<u64>, Option<Height>)> {
    let number = |text: &str| text.parse().ok().filter(|v: &f64| v.is_finite());
    let mut lines = text.lines();
    let words: Vec<&str> = lines.next()?.split_whitespace().collect();
    let (mut begun, mut left) = (None, None);
    for line in lines {
        match line.split_once(' ')? {
            ("begun", at) => begun = Some(at.parse().ok()?),
            ("left", at) => {
                let (above, z) = at.split_once(' ')?;
                left = Some(Height {
                    above: number(above)?,
                    z: number(z)?,
                });
            }
            _ => return None,
        }
    }
    let at = |x: &str, y: &str| Some(Point::new(number(x)?, number(y)?));
    let stop = match words[..] {
        ["none"] => LastStop::None,
        ["unseen"] => LastStop::Unseen(None),
        ["unseen", x, y] => LastStop::Unseen(Some(at(x, y)?)),
        [x, y] => LastStop::At(at(x, y)?),
        _ => return None,
    };
    Some((stop, begun, left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_of_a_stop_outlives_the_program_and_is_an_arms_own() {
        let folder = tempfile::tempdir().expect("folder");
        let open = |serial: &str| Memory::open(folder.path(), serial).expect("opens");
        assert_eq!(open("XI1").stop(), LastStop::None);
        for stop in [
            LastStop::Unseen(None),
            LastStop::Unseen(Some(Point::new(0.5, -0.1))),
            LastStop::At(Point::new(0.5, -0.1)),
            LastStop::None,
        ] {
            open("XI1").keep(stop).expect("keeps");
            assert_eq!(open("XI1").stop(), stop);
            assert_eq!(open("XI2").stop(), LastStop::None);
        }
        fs::write(open("XI1").path(), "0.5 nan").expect("writes");
        assert_eq!(open("XI1").stop(), LastStop::Unseen(None));
    }

    #[test]
    fn a_strike_that_was_begun_and_not_recorded_is_told_by_each_call_until_the_next_one_is_made() {
        let folder = tempfile::tempdir().expect("folder");
        let open = || Memory::open(folder.path(), "XI1").expect("opens");
        let here = Point::new(0.5, 0.1);
        let low = Height {
            above: 0.02,
            z: -0.01,
        };
        assert_eq!(open().lost(), None);
        // Killed in the strike; and after the object was seen to stop.
        for stop in [None, Some(LastStop::At(here)), Some(LastStop::None)] {
            let mut killed = open();
            killed.begin(low).expect("keeps");
            stop.map_or(Ok(()), |stop| killed.keep(stop))
                .expect("keeps");
            for _ in 0..2 {
                let mut next = open();
                let told = next.lost().expect("it is told");
                assert!(told.contains(" s ago"), "{told}");
                assert_eq!(next.lost(), None, "once a call");
                assert_eq!(next.stop(), stop.unwrap_or(LastStop::Unseen(None)));
                assert_eq!(next.left(), Some(low));
            }
            let mut next = open();
            next.begin(low).expect("keeps");
            next.recorded();
            assert_eq!(open().lost(), None);
        }
    }

    #[test]
    fn a_strike_that_is_called_for_is_permitted_where_the_object_was_seen_to_stop_or_was_put() {
        let folder = tempfile::tempdir().expect("folder");
        let open = || Memory::open(folder.path(), "XI1").expect("opens");
        let (here, there) = (Point::new(0.5, 0.1), Point::new(0.3, 0.0));
        assert!(open().permits(here).is_ok());
        open().keep(LastStop::At(here)).expect("keeps");
        assert!(open().permits(here).is_ok());
        open().keep(LastStop::Unseen(None)).expect("keeps");
        // However often it is called.
        for _ in 0..2 {
            let why = open().permits(here).expect_err("nobody put it there");
            assert!(why.contains("(0.500, 0.100)"), "{why}");
        }
        assert!(open().permits(there).is_ok());
    }

    #[test]
    fn an_object_that_was_not_seen_to_stop_is_put_elsewhere_before_it_is_struck() {
        let folder = tempfile::tempdir().expect("folder");
        let (here, near, there) = (
            Point::new(0.5, 0.1),
            Point::new(0.51, 0.1),
            Point::new(0.3, 0.0),
        );
        let mut memory = Memory::open(folder.path(), "XI1").expect("opens");
        assert!(!memory.is_at(here));
        memory.keep(LastStop::Unseen(None)).expect("keeps");
        assert!(memory.is_at(here), "it may have stopped there");
        assert!(memory.is_at(near) && memory.is_at(here));
        // By itself, however far in the end.
        let crept = |step: u32| Point::new(0.5 + 0.015 * f64::from(step), 0.1);
        assert!((1..4).all(|step| memory.is_at(crept(step))));
        assert!(!memory.is_at(there));
    }

    #[test]
    fn a_folder_that_depends_on_where_the_program_is_called_from_is_none() {
        let by = |state: &'static str, home: &'static str| {
            let of = |name: &str| if name == "HOME" { home } else { state };
            folder_by(|name| Some(of(name).into()))
        };
        for (state, home, folder) in [
            ("/s", "/h", Some("/s/carom")),
            ("s", "/h", Some("/h/.local/state/carom")),
            ("", "", None),
            ("", "h", None),
        ] {
            let found = by(state, home).ok();
            assert_eq!(found, folder.map(PathBuf::from), "{state} {home}");
        }
        assert!(folder_by(|_| None).is_err());
    }
}
