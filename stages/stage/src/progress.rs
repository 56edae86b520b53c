//! How far long work has come, on stderr: a bar where a person looks, a line a stage where a file does.

use std::collections::BTreeSet;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar on stderr, one line a stage where stderr is no terminal, or nothing where none is wanted. Usable from any thread.
pub struct Progress {
    bar: ProgressBar,
    /// Whether the runner counts over many batches, so that a stage cannot set the number of items.
    is_counted: bool,
}

/// How often a bar moves while nothing is counted.
const TICK: Duration = Duration::from_millis(120);

impl Progress {
    /// Shows nothing.
    pub fn hidden() -> Self {
        Self {
            bar: ProgressBar::hidden(),
            is_counted: false,
        }
    }

    /// Shows the stage's name and a spinner until the number of items is known.
    pub(crate) fn shown(stage: &'static str) -> Self {
        if !io::stderr().is_terminal() {
            if is_new(stage) {
                print_line(&format!("{stage} …"));
            }
            return Self::hidden();
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        bar.set_style(style("{prefix:>10} {spinner} {elapsed} {msg}"));
        bar.set_prefix(stage);
        bar.enable_steady_tick(TICK);
        Self {
            bar,
            is_counted: false,
        }
    }

    /// This bar, counting to `items`, the number of items of all batches together.
    pub(crate) fn counted(mut self, items: usize) -> Self {
        self.items(items);
        self.is_counted = true;
        self
    }

    /// States how many items there are to do.
    pub fn items(&self, items: usize) {
        if !self.is_counted {
            self.bar.set_style(style(
                "{prefix:>10} [{bar:30}] {human_pos}/{human_len} {eta} {msg}",
            ));
            self.bar.set_position(0);
            self.bar.set_length(items as u64);
        }
    }

    /// Counts items as done.
    pub fn inc(&self, items: usize) {
        self.bar.inc(items as u64);
    }

    /// Says a word about the work, such as the epoch and its loss.
    pub fn set_message(&self, message: impl Into<String>) {
        self.bar.set_message(message.into());
    }

    pub(crate) fn set_done(&self, items: usize) {
        self.bar.set_position(items as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Whether no line of this program has shown the stage yet.
fn is_new(stage: &'static str) -> bool {
    static SHOWN: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
    let mut shown = SHOWN.lock().unwrap_or_else(PoisonError::into_inner);
    shown.insert(stage)
}

/// A line on stderr; that nobody reads it stops no work.
fn print_line(line: &str) {
    drop(writeln!(io::stderr(), "{line}"));
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template)
        .expect("a fixed template")
        .progress_chars("=> ")
}
