//! The three shapes a stage can have.

use serde::{Serialize, de::DeserializeOwned};

use crate::Progress;

/// A stage that answers as a whole. The implementing struct holds its settings, and they are part of the key.
///
/// `run` is a function of settings and input: no clock, environment or global random source, and the same bytes with
/// any number of threads.
pub trait Stage: Serialize + Sync {
    /// Its name: of its folder in the cache, in the summary and in the manifest.
    const NAME: &'static str;
    /// Raised when the meaning of its output, or how it is computed, changes.
    const VERSION: u32;
    /// What it computes from.
    type Input: Serialize + Sync + ?Sized;
    /// Its answer.
    type Output: Serialize + DeserializeOwned + Send;
    /// Why it could not answer.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Computes the answer.
    fn run(&self, input: &Self::Input, progress: &Progress) -> Result<Self::Output, Self::Error>;
}

/// A stage whose answer to one item depends on settings, what is shared, and that item alone.
pub trait ItemStage: Serialize + Sync {
    /// Its name: of its folder in the cache, in the summary and in the manifest.
    const NAME: &'static str;
    /// Raised when the meaning of its output, or how it is computed, changes.
    const VERSION: u32;
    /// Items that one of several workers takes at a time: some tenths of a second's work.
    const BLOCK: usize = 32;
    /// What every item is computed with, such as a world.
    type Shared: Serialize + Sync + ?Sized;
    /// One item.
    type Item: Serialize + Sync;
    /// The answer to one item.
    type Output: Serialize + DeserializeOwned + Send;
    /// Why it could not answer.
    type Error: std::error::Error + Send + Sync + 'static;

    /// How much there is to do for an item, beside others: workers deal their shares by it. No answer depends on it.
    fn cost(_item: &Self::Item) -> u64 {
        1
    }

    /// Computes the answers to these items, in their order. Only items without a kept answer are passed, a batch at a
    /// time; a batch's answers are kept before the next begins. `progress.inc` counts items; `progress.items` has no
    /// effect here, the runner has set it.
    fn run_items(
        &self,
        shared: &Self::Shared,
        items: &[&Self::Item],
        progress: &Progress,
    ) -> Result<Vec<Self::Output>, Self::Error>;
}

/// A stage whose answer to one item is a list that may be larger than memory, and an answer for it as a whole.
pub trait ListStage: Serialize + Sync {
    /// Its name: of its folder in the cache, in the summary and in the manifest.
    const NAME: &'static str;
    /// Raised when the meaning of its output, or how it is computed, changes.
    const VERSION: u32;
    /// What every item is computed with, such as a rig.
    type Shared: Serialize + Sync + ?Sized;
    /// One item.
    type Item: Serialize + Sync;
    /// One of a list.
    type Entry: Serialize + DeserializeOwned + Send;
    /// The answer for one list as a whole.
    type Output: Serialize + DeserializeOwned + Send;
    /// Why it could not answer.
    type Error: std::error::Error + Send + Sync + 'static;

    /// How much there is to do for an item, beside others: workers deal their shares by it. No answer depends on it.
    fn cost(_item: &Self::Item) -> u64 {
        1
    }

    /// Computes the list of one item: hands over each entry when it is found, then returns the answer for the whole. Items are computed
    /// side by side.
    fn run_item(
        &self,
        shared: &Self::Shared,
        item: &Self::Item,
        keep: &mut dyn FnMut(Self::Entry),
    ) -> Result<Self::Output, Self::Error>;
}
