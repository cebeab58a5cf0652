//! A body that rests.
