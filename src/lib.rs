//! The Struna program: scenarios in, records, scores and figures out.
//!
//! `main.rs` parses the command line and hands over to [`commands`]. A [`scenario`] file describes
//! a run; [`session`] builds the chain for it and gathers the [`record`]; [`score`] and [`figure`]
//! read the record and nothing else, and [`mod@compare`] tells how far two results are apart;
//! [`characterize`] finds a gyro's noise in what it read at rest, [`mod@smooth`] looks back over a
//! recorded run, and [`validate`] tells how far each estimator can be trusted.

pub mod backend;
pub mod characterize;
pub mod cli;
pub mod commands;
pub mod compare;
pub mod devices;
pub mod emulate;
pub mod faults;
pub mod figure;
pub mod fmu;
pub mod frames;
pub mod hil;
pub mod in_process;
pub mod output;
pub mod progress;
pub mod record;
pub mod recording;
pub mod report;
pub mod scenario;
pub mod score;
pub mod session;
pub mod smooth;
pub mod three_axes;
pub mod validate;
