//! Live buses through a whole session.
