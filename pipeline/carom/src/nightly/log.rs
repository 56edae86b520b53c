//! Log lines as JSON, on request: for a journal that a machine reads.

use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

/// Lines on standard error, if they are wanted.
pub struct Log<'a> {
    is_wanted: bool,
    rig: Option<&'a str>,
}

impl<'a> Log<'a> {
    /// The log of a night, of a rig where it is one of a fleet.
    pub fn new(is_wanted: bool, rig: Option<&'a str>) -> Self {
        Self { is_wanted, rig }
    }

    /// One object on a line: `time` in seconds since the epoch, `level`, `event`, the `rig` of a fleet and what belongs to it.
    pub fn line(&self, level: &str, event: &str, more: &Value) {
        if !self.is_wanted {
            return;
        }
        let time = SystemTime::now().duration_since(UNIX_EPOCH);
        let mut line = json!({
            "time": time.map_or(0.0, |time| time.as_secs_f64()), "level": level, "event": event,
        });
        if let Some(rig) = self.rig {
            line["rig"] = rig.into();
        }
        if let (Some(line), Some(more)) = (line.as_object_mut(), more.as_object()) {
            line.extend(more.clone());
        }
        // The reader of standard error may have closed it; the night's work continues.
        let _ = writeln!(std::io::stderr(), "{line}");
    }
}
