//! A shared library with one model that misbehaves on demand. Tests load it; nothing ships it.

mod model;

use struna_fmi_export::{ModelType, export_fmi};

static MODELS: [ModelType; 1] = [ModelType::of::<model::Probe>()];

export_fmi!(crate::MODELS);
