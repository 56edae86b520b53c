//! What a hard set is for.

use serde::{Deserialize, Serialize};

values::named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum HardKind {
        /// Nothing hidden but noise.
        Control = "control",
        /// One phenomenon that has a name, at twice the floor and more.
        Single = "single",
        /// One of them, below twice the floor.
        Weak = "weak",
        /// Two or three of them, each at twice the floor and more.
        Several = "several",
        /// What no candidate has, at twice the floor and more.
        Foreign = "foreign",
        /// An arm that errs by where the object lies, at twice the floor and more.
        Place = "place",
        /// What changes with the order otherwise than by wear, at twice the floor and more.
        Order = "order",
        /// What is neither noise nor an effect: no name is right.
        Odd = "odd",
    }
}

/// Number of sets of each kind among twenty.
pub(super) const OF_TWENTY: [(HardKind, usize); 8] = [
    (HardKind::Control, 8),
    (HardKind::Single, 3),
    (HardKind::Weak, 1),
    (HardKind::Several, 1),
    (HardKind::Foreign, 2),
    (HardKind::Place, 2),
    (HardKind::Order, 2),
    (HardKind::Odd, 1),
];

impl HardKind {
    /// The kind under which its phenomena are listed.
    pub(super) fn listed(self) -> Self {
        match self {
            Self::Weak | Self::Several => Self::Single,
            other => other,
        }
    }
}
