//! The macro that gives a shared library its C symbols, and its parts.
//!
//! Symbols come from a macro, not from this crate, so that only libraries that ask for them have
//! them.

/// Exports a list of models (a `static` array of [`ModelType`](crate::ModelType)) as an FMU of both
/// versions of FMI.
///
/// Defines every C symbol of a co-simulation FMU in two public modules, `fmi2` and `fmi3`. Use it
/// once in a shared library.
///
/// ```
/// # mod swing {
/// #     use struna_fmi_export::{
/// #         DefaultExperiment, Domain, Model, ModelDescription, ModelError, Role, Unit, Values,
/// #         Variable,
/// #     };
/// #     #[derive(Debug)]
/// #     pub struct Swing;
/// #     static TABLE: [Variable; 2] = [
/// #         Variable::TIME,
/// #         Variable::new(1, Role::Input, "angle_rad", Domain::float64(Unit::RAD, 0.0), ""),
/// #     ];
/// #     impl Model for Swing {
/// #         const DESCRIPTION: ModelDescription = ModelDescription::new(
/// #             "Swing", "1", "",
/// #             DefaultExperiment { stop_time_s: 1.0, step_size_s: 0.1 }, &TABLE,
/// #         );
/// #         fn initialise(_: &Values, _: f64) -> Result<Self, ModelError> { Ok(Swing) }
/// #         fn step(&mut self, _: &Values, _: f64, _: f64) -> Result<(), ModelError> { Ok(()) }
/// #         fn write_outputs(&self, _: &mut Values) {}
/// #         fn save(&self, _: &mut Vec<u8>) {}
/// #         fn restore(_: &Values, _: &[u8]) -> Result<Self, ModelError> { Ok(Swing) }
/// #     }
/// # }
/// use struna_fmi_export::{ModelType, export_fmi};
///
/// static MODELS: [ModelType; 1] = [ModelType::of::<swing::Swing>()];
/// export_fmi!(crate::MODELS);
/// # fn main() {}
/// ```
#[macro_export]
macro_rules! export_fmi {
    ($models:path) => {
        /// The exported functions of FMI 2.0.
        #[allow(unsafe_code, reason = "a C interface")]
        #[allow(non_snake_case, reason = "the names of the standard")]
        #[allow(clippy::too_many_arguments, reason = "the signatures of the standard")]
        #[allow(clippy::wildcard_imports, reason = "the C types of the standard")]
        pub mod fmi2 {
            $crate::__export_fmi2!($models);
        }

        /// The exported functions of FMI 3.0.
        #[allow(unsafe_code, reason = "a C interface")]
        #[allow(non_snake_case, reason = "the names of the standard")]
        #[allow(clippy::too_many_arguments, reason = "the signatures of the standard")]
        #[allow(clippy::wildcard_imports, reason = "the C types of the standard")]
        pub mod fmi3 {
            $crate::__export_fmi3!($models);
        }
    };
}

/// Functions forwarded, with their own name in front, to the function after the equals sign.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_functions {
    ($($name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? = $call:path;)*) => {$(
        #[doc = concat!("`", stringify!($name), "` of the FMI standard.")]
        ///
        /// # Safety
        /// Every pointer must be what the standard asks for, and no other thread may be inside a
        /// call with the same instance.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
            // SAFETY: the caller's promises are those asked for.
            unsafe { $call(stringify!($name), $($argument),*) }
        }
    )*};
}

/// Functions that exist because the standard says so, and refuse for the reason given.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_refused_functions {
    ($(
        $name:ident($handle:ident: $handle_type:ty $(, $argument:ident: $type:ty)* $(,)?)
            -> $result:ty = $reason:expr;
    )*) => {$(
        #[doc = concat!("`", stringify!($name), "` of the FMI standard: refused, with a log line.")]
        ///
        /// # Safety
        /// No other thread may be inside a call with the same instance.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($handle: $handle_type $(, $argument: $type)*) -> $result {
            $(let _ = $argument;)*
            // SAFETY: the caller's promises are those asked for.
            unsafe { $crate::refuse($handle, stringify!($name), $reason) }
        }
    )*};
}

/// Functions that answer with a constant text.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_constant_texts {
    ($($name:ident() -> $result:ty = $text:expr;)*) => {$(
        #[doc = concat!("`", stringify!($name), "` of the FMI standard.")]
        ///
        /// # Safety
        /// Always safe to call.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name() -> $result {
            let text: &'static ::std::ffi::CStr = $text;
            text.as_ptr()
        }
    )*};
}
