//! `carom query`: a question to the tables of a run, in SQL.
//!
//! The Parquet tables of the folder and the predictions of `evaluation.json` are loaded into SQLite, in memory; nothing is written.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use judge::Evaluation;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, ToSql, params, params_from_iter};
use serde_json::{Map, json};
use tables::{Reader, TableError, Value};

use crate::Error;
use crate::error::Output;

/// `carom query`.
#[derive(Args, Debug)]
pub struct QueryArgs {
    /// Folder of a run.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// The question, such as "SELECT session, count(*) FROM strikes GROUP BY session".
    #[arg(value_name = "SELECT", required = true, num_args = 1..)]
    pub sql: Vec<String>,
}

/// Asks, and prints the rows.
pub fn run(args: &QueryArgs) -> Result<Output, Error> {
    let mut loading = Loading {
        database: Connection::open_in_memory().map_err(Error::failed)?,
        insert: String::new(),
    };
    loading
        .database
        .execute_batch("BEGIN")
        .map_err(Error::failed)?;
    tables::read_all(&args.dir, &mut loading)?;
    let Loading { database, .. } = loading;
    load_predictions(&database, &args.dir)?;
    // What is asked changes nothing, neither here nor in a file that it names.
    let sealed = database.execute_batch("COMMIT; PRAGMA query_only = ON");
    sealed.map_err(Error::failed)?;
    answer(&database, &args.sql.join(" ")).map_err(|error| {
        let known = described(&database).unwrap_or_default();
        Error::input(format!(
            "ask the tables of {}: {error}; a column that is named as a word of SQL is written in double quotes: \"index\"; there are\n{known}",
            args.dir.display()
        ))
    })
}

/// The tables as they are read into SQLite.
struct Loading {
    database: Connection,
    insert: String,
}

/// The library's error, or that of a table.
struct LoadError(Error);

impl From<TableError> for LoadError {
    fn from(error: TableError) -> Self {
        Self(Error::input(error))
    }
}

impl From<LoadError> for Error {
    fn from(error: LoadError) -> Self {
        error.0
    }
}

impl From<rusqlite::Error> for LoadError {
    fn from(error: rusqlite::Error) -> Self {
        Self(Error::failed(error))
    }
}

impl Reader for Loading {
    type Error = LoadError;

    fn table(&mut self, name: &str, columns: &[&str]) -> Result<(), LoadError> {
        let quoted: Vec<String> = columns.iter().map(|name| format!("\"{name}\"")).collect();
        let made = format!("CREATE TABLE \"{name}\" ({})", quoted.join(", "));
        self.database.execute_batch(&made)?;
        let places = vec!["?"; columns.len()].join(", ");
        self.insert = format!("INSERT INTO \"{name}\" VALUES ({places})");
        Ok(())
    }

    fn row(&mut self, cells: &[Value<'_>]) -> Result<(), LoadError> {
        let values = cells.iter().map(|cell| -> Box<dyn ToSql + '_> {
            match cell {
                Value::Nothing => Box::new(rusqlite::types::Null),
                Value::Real(number) => Box::new(number),
                Value::Count(count) => Box::new(count),
                Value::Text(text) => Box::new(text),
            }
        });
        self.database
            .execute(&self.insert, params_from_iter(values))?;
        Ok(())
    }
}

/// What each model said of each held-out strike, where the run came so far: `predictions`.
fn load_predictions(database: &Connection, dir: &Path) -> Result<(), Error> {
    let path = dir.join("evaluation.json");
    let Ok(bytes) = std::fs::read(&path) else {
        return Ok(());
    };
    let evaluation: Evaluation = serde_json::from_slice(&bytes)
        .map_err(|error| Error::input(format!("read {}: {error}", path.display())))?;
    let load = || -> rusqlite::Result<()> {
        database.execute_batch(
            "CREATE TABLE predictions (model, strike_id, stop_x, stop_y, error, status)",
        )?;
        let mut insert = database.prepare("INSERT INTO predictions VALUES (?, ?, ?, ?, ?, ?)")?;
        for row in &evaluation.predictions {
            let (x, y) = row.stop.map(|stop| (stop.x, stop.y)).unzip();
            let status = serde_json::to_value(row.status).unwrap_or_default();
            insert.execute(params![
                row.model,
                row.strike_id,
                x,
                y,
                row.error,
                status.as_str()
            ])?;
        }
        Ok(())
    };
    load().map_err(Error::failed)
}

/// Each table with its columns, a line each.
fn described(database: &Connection) -> rusqlite::Result<String> {
    let mut tables = database.prepare(
        "SELECT m.name, group_concat(c.name, ', ') FROM sqlite_master m, pragma_table_info(m.name) c \
         WHERE m.type = 'table' GROUP BY m.name",
    )?;
    let line = |row: &rusqlite::Row<'_>| {
        let (name, columns): (String, String) = (row.get(0)?, row.get(1)?);
        Ok(format!("{name}: {columns}"))
    };
    let lines: Vec<String> = tables.query_map([], line)?.collect::<Result<_, _>>()?;
    Ok(lines.join("\n"))
}

fn answer(database: &Connection, sql: &str) -> rusqlite::Result<Output> {
    let mut statement = database.prepare(sql)?;
    let names: Vec<String> = statement.column_names().map(String::from).collect();
    let mut found = statement.query([])?;
    let (mut objects, mut lines) = (Vec::new(), vec![names.clone()]);
    while let Some(row) = found.next()? {
        let (mut object, mut line) = (Map::new(), Vec::new());
        for (place, name) in names.iter().enumerate() {
            let (value, text) = match row.get_ref(place)? {
                ValueRef::Null => (json!(null), String::new()),
                ValueRef::Integer(number) => (json!(number), number.to_string()),
                ValueRef::Real(number) => (json!(number), number.to_string()),
                ValueRef::Text(bytes) | ValueRef::Blob(bytes) => {
                    let text = String::from_utf8_lossy(bytes).into_owned();
                    (json!(text), text)
                }
            };
            object.insert(name.clone(), value);
            line.push(text);
        }
        objects.push(serde_json::Value::Object(object));
        lines.push(line);
    }
    let widths: Vec<usize> = (0..names.len())
        .map(|place| {
            lines
                .iter()
                .map(|line| line[place].chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    let mut text = String::new();
    for line in &lines {
        let cells: Vec<String> = line
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        let _ = writeln!(text, "{}", cells.join("  ").trim_end());
    }
    Ok(Output::done(json!(objects), text))
}

#[cfg(test)]
mod tests {
    use values::{Reject, RejectReason};

    use super::*;

    fn ask(dir: &Path, sql: &str) -> Result<Output, Error> {
        run(&QueryArgs {
            dir: dir.into(),
            sql: vec![sql.into()],
        })
    }

    #[test]
    fn tables_are_asked_together_and_an_unknown_column_names_those_that_there_are() {
        let dir = tempfile::tempdir().expect("folder");
        let reject = |index: u32| Reject {
            log: if index == 0 { "a" } else { "b" }.into(),
            index,
            t_start: f64::from(index),
            reason: RejectReason::NoMotion,
            detail: String::new(),
        };
        let rejects: Vec<Reject> = (0..3).map(reject).collect();
        tables::write_rejects(dir.path(), &rejects).expect("written");
        let counted = ask(
            dir.path(),
            "SELECT log, count(*) AS n FROM rejects GROUP BY log ORDER BY n",
        )
        .expect("rows");
        assert_eq!(
            counted.json,
            json!([{ "log": "a", "n": 1 }, { "log": "b", "n": 2 }])
        );
        assert_eq!(counted.text, "log  n\na    1\nb    2\n");
        let error = ask(dir.path(), "SELECT speed FROM rejects").expect_err("no such column");
        assert!(error.to_string().contains("rejects: log, "), "{error}");
        let error = ask(dir.path(), "DELETE FROM rejects").expect_err("read alone");
        assert_eq!(error.outcome() as u8, 2, "{error}");
    }
}
