//! Objects without a dictionary: the data types of the standard's own objects, and how values are read.
//!
//! It must not hold names: those are words and stand in `text::terms`.
