//! Blocks in, items out.
