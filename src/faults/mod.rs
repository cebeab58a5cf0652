//! Which detector finds which fault: streams, faults, trials and the table.
//!
//! Everything runs in simulated time: a gyro on a known motion, its frames, the faults of a plan,
//! a line behind a bridge, a decoder and a monitor. One seed makes one table on any number of
//! threads.

mod cases;
mod figure;
mod matrix;
mod motion;
mod streams;
mod table;
mod trial;
mod unseen;

pub use cases::{Case, Family, cases};
pub use figure::svg;
pub use matrix::{Ablation, Cell, Clean, Matrix, Row, StreamMatrix, Suite, run};
pub use motion::TestMotion;
pub use streams::Stream;
pub use table::write_csv;
pub use trial::{Trial, trial};
pub use unseen::unseen;
