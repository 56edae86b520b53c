//! The rows of a rosbag2 file that SQLite holds.
//!
//! Source: ros2/rosbag2, `rosbag2_storage_sqlite3`: tables `topics`, `messages` and, since Iron, `message_definitions`.

use std::collections::BTreeMap;
use std::path::Path;

use rusqlite::limits::Limit;
use rusqlite::{Connection, Error, ErrorCode, OpenFlags};

use super::event::Limits;
use crate::LogError;
use crate::write::known_definition;

/// A topic: its number, name, messages' type and encoding.
pub(super) struct Topic {
    pub(super) id: i64,
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) encoding: String,
}

/// A definition's encoding and text.
pub(super) type Definition = (String, String);

/// Called with the topic, time of receipt (ns) and bytes of a message.
type EachRow<'a, E> = &'a mut dyn FnMut(i64, u64, &[u8]) -> Result<(), E>;

/// A file's connection.
pub(super) struct Database<'a> {
    log: &'a str,
    connection: Connection,
    limit: usize,
}

impl<'a> Database<'a> {
    /// Opens a file that nothing writes to; `log` is its name in errors.
    pub(super) fn open(log: &'a str, path: &Path, limits: Limits) -> Result<Self, LogError> {
        let failed = |why: String| LogError::Sqlite {
            log: log.into(),
            why,
        };
        let beside = format!("{}-wal", path.display());
        if std::fs::metadata(&beside).is_ok_and(|file| file.len() > 0) {
            return Err(failed(format!(
                "its recording did not end, and messages are in {beside}: end it with `sqlite3 {} 'PRAGMA wal_checkpoint(TRUNCATE)'`",
                path.display()
            )));
        }
        let place = path.display().to_string();
        let place = place
            .replace('%', "%25")
            .replace('?', "%3f")
            .replace('#', "%23");
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
            | OpenFlags::SQLITE_OPEN_URI
            | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        // Immutable: no lock and no other file is made beside it.
        let connection = Connection::open_with_flags(format!("file:{place}?immutable=1"), flags)
            .map_err(|error| failed(error.to_string()))?;
        let limit = i32::try_from(limits.record).unwrap_or(i32::MAX);
        connection
            .set_limit(Limit::SQLITE_LIMIT_LENGTH, limit)
            .map_err(|error| failed(error.to_string()))?;
        let database = Self {
            log,
            connection,
            limit: limits.record,
        };
        for table in ["topics", "messages"] {
            if !database.has(table)? {
                return Err(failed(format!(
                    "it has no table `{table}`, and is none of rosbag2's"
                )));
            }
        }
        Ok(database)
    }

    fn has(&self, table: &str) -> Result<bool, LogError> {
        let sql = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = ?1";
        let count: i64 = self
            .connection
            .query_row(sql, [table], |row| row.get(0))
            .map_err(|error| self.failed(&error))?;
        Ok(count == 1)
    }

    pub(super) fn topics(&self) -> Result<Vec<Topic>, LogError> {
        let sql = "SELECT id, name, type, serialization_format FROM topics ORDER BY id";
        self.rows(sql, |row| {
            Ok(Topic {
                id: row.get(0)?,
                name: row.get(1)?,
                kind: row.get(2)?,
                encoding: row.get(3)?,
            })
        })
    }

    /// Definitions by the types that they define; recorders before Iron kept none, and of common types they are known.
    pub(super) fn definitions(
        &self,
        topics: &[Topic],
    ) -> Result<BTreeMap<String, Definition>, LogError> {
        let mut definitions: BTreeMap<String, Definition> = BTreeMap::new();
        if self.has("message_definitions")? {
            let sql =
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions";
            let rows = self.rows(sql, |row| Ok((row.get(0)?, (row.get(1)?, row.get(2)?))))?;
            definitions.extend(rows);
        }
        for topic in topics {
            let is_there = definitions
                .get(&topic.kind)
                .is_some_and(|(_, text)| !text.trim().is_empty());
            if let (false, Some(text)) = (is_there, known_definition(&topic.kind)) {
                definitions.insert(topic.kind.clone(), ("ros2msg".into(), text));
            }
        }
        Ok(definitions)
    }

    /// Calls `each` with the topic, time of receipt and bytes of every message, in order of time; inside, what damage ended the rows.
    pub(super) fn messages<E: From<LogError>>(
        &self,
        each: EachRow<'_, E>,
    ) -> Result<Result<(), String>, E> {
        let sql = "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id";
        let prepared = self.connection.prepare(sql);
        let mut statement = prepared.map_err(|error| self.failed(&error))?;
        let rows = statement.query([]);
        let mut rows = rows.map_err(|error| self.failed(&error))?;
        loop {
            let row = match rows.next() {
                Ok(Some(row)) => row,
                Ok(None) => return Ok(Ok(())),
                Err(error) if error.sqlite_error_code() == Some(ErrorCode::TooBig) => {
                    return Err(E::from(LogError::TooLarge {
                        log: self.log.into(),
                        what: "message",
                        offset: 0,
                        size: self.limit as u64 + 1,
                        limit: self.limit as u64,
                    }));
                }
                Err(error) => return Ok(Err(error.to_string())),
            };
            let (topic, time) = match (row.get(0), row.get::<_, i64>(1)) {
                (Ok(topic), Ok(time)) => (topic, u64::try_from(time).unwrap_or(0)),
                (Err(error), _) | (_, Err(error)) => return Ok(Err(error.to_string())),
            };
            match row
                .get_ref(2)
                .map(|data| data.as_blob().map(<[u8]>::to_vec))
            {
                Ok(Ok(data)) => each(topic, time, &data)?,
                _ => return Ok(Err("a message is no bytes".into())),
            }
        }
    }

    fn rows<T>(
        &self,
        sql: &str,
        row: impl FnMut(&rusqlite::Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, LogError> {
        let read = || -> rusqlite::Result<Vec<T>> {
            let mut statement = self.connection.prepare(sql)?;
            statement.query_map([], row)?.collect()
        };
        read().map_err(|error| self.failed(&error))
    }

    fn failed(&self, error: &Error) -> LogError {
        LogError::Sqlite {
            log: self.log.into(),
            why: error.to_string(),
        }
    }
}
