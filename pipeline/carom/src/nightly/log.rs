//! Log lines as JSON, on request: for a journal that a machine reads.

use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

/// Lines on standard error, if they are wanted.
pub struct Log {
    is_wanted: bool,
}

impl Log {
    pub fn new(is_wanted: bool) -> Self {
        Self { is_wanted }
    }

    /// One object on a line: `time` in seconds since the epoch, `level`, `event` and what belongs to it.
    pub fn line(&self, level: &str, event: &str, more: &Value) {
        if !self.is_wanted {
            return;
        }
        let time = SystemTime::now().duration_since(UNIX_EPOCH);
        let mut line = json!({
            "time": time.map_or(0.0, |time| time.as_secs_f64()), "level": level, "event": event,
        });
        if let (Some(line), Some(more)) = (line.as_object_mut(), more.as_object()) {
            line.extend(more.clone());
        }
        // The reader of standard error may have closed it; the night's work continues.
        let _ = writeln!(std::io::stderr(), "{line}");
    }
}
