//! The stage: one log is one item.

use logs::LogError;
use stage::ListStage;
use values::{Rig, Strike};

use crate::Ingest;
use crate::error::IngestError;
use crate::log::read_log;
use crate::outcome::{LogFile, LogOutcome, StrikeSummary};

impl ListStage for Ingest {
    const NAME: &'static str = "ingest";
    const VERSION: u32 = 36;
    type Shared = Rig;
    type Item = LogFile;
    type Entry = Strike;
    type Output = LogOutcome<StrikeSummary>;
    type Error = IngestError;

    fn cost(log: &LogFile) -> u64 {
        std::fs::metadata(&log.path).map_or(0, |metadata| metadata.len())
    }

    fn run_item(
        &self,
        rig: &Rig,
        log: &LogFile,
        keep: &mut dyn FnMut(Strike),
    ) -> Result<LogOutcome<StrikeSummary>, IngestError> {
        let read = read_log(&log.path, &log.name, rig, self.seed, keep);
        match read.and_then(|read| log.check(read)) {
            // A disk may do better the next time: that answer is not one to keep.
            Err(error @ IngestError::Log(LogError::Io { .. })) => Err(error),
            Err(error @ IngestError::Changed { .. }) => Err(error),
            // One log that is none does not take the others with it; but what is said of it must be true of what was hashed.
            Err(error) if logs::hash(&log.path)? == log.sha256 => {
                Ok(LogOutcome::left_out(log, &error))
            }
            Err(_) => Err(log.changed()),
            read => read,
        }
    }
}
