//! strike
