//! The structure of `src`, kept: which module may use which, that files do not use each other in circles, and what few
//! places may hold.
//!
//! The compiler allows every use inside a crate. A use against the order fails here, before somebody builds on it.

#![allow(clippy::expect_used, clippy::panic)]

mod circles;
mod may_use;
mod order;
mod places;
mod sources;
