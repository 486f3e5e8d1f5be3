//! The tables against what is fed: names and types frozen, rows and their nulls, the ends of batches.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
