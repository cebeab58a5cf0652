//! FMI 2.0 for co-simulation.

pub mod calls;
pub(crate) mod description;
pub mod types;

mod functions;
