//! The C functions, called as an importer would, with arguments that no importer should pass.

#![expect(unsafe_code, reason = "calls C functions")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut, without_provenance_mut};
use struna_fmi_export::{FmiVersion, ModelType, export_fmi};

#[path = "../examples/probe/model.rs"]
mod model;

static MODELS: [ModelType; 1] = [ModelType::of::<model::Probe>()];

export_fmi!(crate::MODELS);

const OK: u32 = 0;
const ERROR: u32 = 3;
const FATAL: u32 = 4;

const RATE_RAD_S: u32 = 1;
const PANIC_NOW: u32 = 3;
const ANGLE_RAD: u32 = 9;
const COUNT: u32 = 10;
const ODD: u32 = 11;

/// Log lines of one instance; its address is the instance environment.
#[derive(Default)]
struct Lines(Vec<(u32, String)>);

unsafe extern "C" fn log(lines: *mut c_void, status: u32, _: *const c_char, line: *const c_char) {
    // SAFETY: every instance below is made with its `Lines` as environment and a terminated line.
    let (lines, line) = unsafe { (&mut *lines.cast::<Lines>(), CStr::from_ptr(line)) };
    lines.0.push((status, line.to_string_lossy().into_owned()));
}

fn instantiate_with(token: &str, lines: &mut Lines) -> *mut c_void {
    let token = CString::new(token).expect("no token holds a zero byte");
    let environment = (&raw mut *lines).cast();
    // SAFETY: the texts are terminated and the callback fits the environment.
    unsafe {
        fmi3::fmi3InstantiateCoSimulation(
            c"probe".as_ptr(),
            token.as_ptr(),
            null(),
            false,
            true,
            false,
            false,
            null(),
            0,
            environment,
            Some(log),
            None,
        )
    }
}

/// An instance in step mode.
fn running(lines: &mut Lines) -> *mut c_void {
    let instance = instantiate_with(MODELS[0].instantiation_token(), lines);
    assert!(!instance.is_null());
    // SAFETY: a live instance, used by this thread alone.
    unsafe {
        let status = fmi3::fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0);
        assert_eq!((status, fmi3::fmi3ExitInitializationMode(instance)), (OK, OK));
    }
    instance
}

fn step(instance: *mut c_void, time_s: f64, step_s: f64) -> u32 {
    let none = null_mut();
    // SAFETY: the importer may leave out results that it does not want.
    unsafe { fmi3::fmi3DoStep(instance, time_s, step_s, true, none, none, none, null_mut()) }
}

fn set(instance: *mut c_void, reference: u32, value: f64) -> u32 {
    // SAFETY: the arrays have one element each.
    unsafe { fmi3::fmi3SetFloat64(instance, &raw const reference, 1, &raw const value, 1) }
}

fn get(instance: *mut c_void, reference: u32) -> f64 {
    let mut value = f64::NAN;
    // SAFETY: the arrays have one element each.
    let status =
        unsafe { fmi3::fmi3GetFloat64(instance, &raw const reference, 1, &raw mut value, 1) };
    assert_eq!(status, OK);
    value
}

/// The probe's count, and whether it is odd, which it calculates on demand.
fn count_and_odd(instance: *mut c_void) -> (i32, bool) {
    let (count, odd) = ([COUNT], [ODD]);
    let (mut counted, mut is_odd) = ([0], [false]);
    // SAFETY: the arrays have one element each.
    unsafe {
        let status = fmi3::fmi3GetBoolean(instance, odd.as_ptr(), 1, is_odd.as_mut_ptr(), 1);
        assert_eq!(status, OK);
        let status = fmi3::fmi3GetInt32(instance, count.as_ptr(), 1, counted.as_mut_ptr(), 1);
        assert_eq!(status, OK);
    }
    (counted[0], is_odd[0])
}

fn free(instance: *mut c_void) {
    // SAFETY: used by this thread alone.
    unsafe { fmi3::fmi3FreeInstance(instance) }
}

#[test]
fn null_and_made_up_handles_are_refused_without_being_followed() {
    let mut lines = Lines::default();
    let live = running(&mut lines);
    for made_up in [0, 1, 0x4000, 0xdead_beef_0000, usize::MAX, live.addr() + 0x4000] {
        let handle = without_provenance_mut(made_up);
        assert_eq!(step(handle, 0.0, 1.0), ERROR, "{made_up:#x}");
        free(handle);
    }
    assert_eq!(step(live, 0.0, 1.0), OK, "freeing made-up handles touched a live instance");
    free(live);
}

#[test]
fn a_freed_handle_is_refused_even_when_its_place_is_taken_again() {
    let (mut lines, mut more) = (Lines::default(), Lines::default());
    let freed = running(&mut lines);
    free(freed);
    let next = running(&mut more);
    assert_eq!(step(freed, 0.0, 1.0), ERROR);
    free(freed);
    assert_eq!(step(next, 0.0, 1.0), OK);
    free(next);
}

#[test]
fn null_arrays_are_refused_unless_they_are_empty() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    let (reference, value) = (RATE_RAD_S, 1.0);
    // SAFETY: every array is null or has one element.
    unsafe {
        assert_eq!(fmi3::fmi3SetFloat64(instance, null(), 0, null(), 0), OK);
        assert_eq!(fmi3::fmi3SetFloat64(instance, null(), 1, &raw const value, 1), ERROR);
        assert_eq!(fmi3::fmi3SetFloat64(instance, &raw const reference, 1, null(), 1), ERROR);
        assert_eq!(fmi3::fmi3GetFloat64(instance, &raw const reference, 1, null_mut(), 1), ERROR);
        assert_eq!(fmi3::fmi3SetFloat64(instance, &raw const reference, 1, null(), 0), ERROR);
        assert_eq!(fmi3::fmi3GetFMUState(instance, null_mut()), ERROR);
        assert_eq!(fmi3::fmi3SetFMUState(instance, null_mut()), ERROR);
        assert_eq!(fmi3::fmi3FreeFMUState(instance, null_mut()), OK);
        assert_eq!(fmi3::fmi3SerializedFMUStateSize(instance, null_mut(), null_mut()), ERROR);
        assert_eq!(fmi3::fmi3DeserializeFMUState(instance, null(), 9, null_mut()), ERROR);
        assert_eq!(fmi3::fmi3SetDebugLogging(instance, true, 1, null()), ERROR);
        assert_eq!(fmi3::fmi3SetDebugLogging(instance, true, 1, &null()), ERROR);
    }
    assert_eq!(lines.0.len(), 10, "{:?}", lines.0);
    free(instance);
}

#[test]
fn a_set_of_several_variables_takes_all_or_none() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    assert_eq!(set(instance, RATE_RAD_S, 0.5), OK);
    let (references, values) = ([RATE_RAD_S, ANGLE_RAD], [0.75, 0.0]);
    // SAFETY: the arrays have two elements each.
    let status =
        unsafe { fmi3::fmi3SetFloat64(instance, references.as_ptr(), 2, values.as_ptr(), 2) };
    assert_eq!((status, get(instance, RATE_RAD_S).to_bits()), (ERROR, 0.5_f64.to_bits()));
    free(instance);
}

#[test]
fn an_output_on_demand_is_that_of_the_last_completed_step() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    assert_eq!(count_and_odd(instance), (-7, true));
    assert_eq!(step(instance, 0.0, 1.0), OK);
    assert_eq!(count_and_odd(instance), (-6, false));
    // Three steps of which nobody reads the outputs, and one that is refused.
    for time_s in [1.0, 2.0, 3.0] {
        assert_eq!(step(instance, time_s, 1.0), OK);
    }
    assert_eq!(step(instance, 9.0, 1.0), ERROR);
    assert_eq!(count_and_odd(instance), (-3, true));
    assert_eq!(step(instance, 4.0, 1.0), OK);
    // SAFETY: a live instance, used by this thread alone.
    assert_eq!(unsafe { fmi3::fmi3Terminate(instance) }, OK);
    assert_eq!(count_and_odd(instance), (-2, false));
    free(instance);
}

#[test]
fn an_output_on_demand_is_saved_with_the_state_though_nobody_has_read_it() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    let mut state = null_mut();
    assert_eq!(step(instance, 0.0, 1.0), OK);
    // SAFETY: a live instance, used by this thread alone, and a pointer to a local.
    assert_eq!(unsafe { fmi3::fmi3GetFMUState(instance, &raw mut state) }, OK);
    assert_eq!(count_and_odd(instance), (-6, false));
    // Restored while the output of a later step is still to be calculated.
    assert_eq!(step(instance, 1.0, 1.0), OK);
    // SAFETY: as above.
    assert_eq!(unsafe { fmi3::fmi3SetFMUState(instance, state) }, OK);
    assert_eq!(count_and_odd(instance), (-6, false));
    free(instance);
}

#[test]
fn a_state_buffer_that_is_too_small_is_left_alone() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    let (mut state, mut size) = (null_mut(), 0);
    // SAFETY: pointers to locals, and a buffer of the size told.
    unsafe {
        assert_eq!(fmi3::fmi3GetFMUState(instance, &raw mut state), OK);
        assert_eq!(fmi3::fmi3SerializedFMUStateSize(instance, state, &raw mut size), OK);
        let mut buffer = vec![0xaa_u8; size];
        let short = fmi3::fmi3SerializeFMUState(instance, state, buffer.as_mut_ptr(), size - 1);
        assert_eq!(short, ERROR);
        assert!(buffer.iter().all(|&byte| byte == 0xaa));
        assert_eq!(fmi3::fmi3SerializeFMUState(instance, state, buffer.as_mut_ptr(), size), OK);
        // Saving over a known state takes no new place.
        let before = state;
        assert_eq!(fmi3::fmi3GetFMUState(instance, &raw mut state), OK);
        assert_eq!(state, before);
        let mut made_up = without_provenance_mut(0xbad);
        assert_eq!(fmi3::fmi3GetFMUState(instance, &raw mut made_up), ERROR);
    }
    free(instance);
}

/// An importer that steps its instance from the instance's own log callback.
unsafe extern "C" fn step_again(
    environment: *mut c_void,
    _: u32,
    _: *const c_char,
    _: *const c_char,
) {
    // SAFETY: the environment below is a pair of handle and answer.
    let (handle, answer) = unsafe { &mut *environment.cast::<(*mut c_void, Option<u32>)>() };
    *answer = Some(step(*handle, 0.0, 1.0));
    free(*handle);
}

#[test]
fn calling_back_from_the_log_callback_is_refused() {
    let mut pair: (*mut c_void, Option<u32>) = (null_mut(), None);
    let token = CString::new(MODELS[0].instantiation_token()).unwrap();
    let environment = &raw mut pair;
    // SAFETY: the texts are terminated; `pair` outlives the instance and is reached only through
    // `environment` while it lives.
    unsafe {
        let (name, token) = (c"probe".as_ptr(), token.as_ptr());
        let handle = fmi3::fmi3InstantiateCoSimulation(
            name,
            token,
            null(),
            false,
            true,
            false,
            false,
            null(),
            0,
            environment.cast(),
            Some(step_again),
            None,
        );
        (*environment).0 = handle;
        assert_eq!(fmi3::fmi3Terminate(handle), ERROR);
        assert_eq!((*environment).1, Some(ERROR));
        let status = fmi3::fmi3EnterInitializationMode(handle, false, 0.0, 0.0, false, 0.0);
        assert_eq!(status, OK, "the instance must have outlived the attempt to free it");
        free(handle);
    }
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    let n = null_mut();
    // SAFETY: refused before any array is looked at.
    unsafe {
        assert_eq!(fmi3::fmi3GetFloat32(instance, null(), 1, null_mut(), 1), ERROR);
        assert_eq!(fmi3::fmi3EnterConfigurationMode(instance), ERROR);
        assert_eq!(fmi3::fmi3GetNumberOfContinuousStates(instance, n), ERROR);
        assert_eq!(fmi2::fmi2CancelStep(instance), ERROR);
    }
    let said: Vec<_> = lines.0.iter().map(|(_, line)| line.as_str()).collect();
    assert_eq!(
        said,
        [
            "fmi3GetFloat32: not supported: there are no Float32 variables",
            "fmi3EnterConfigurationMode: not supported: there are no structural parameters",
            "fmi3GetNumberOfContinuousStates: not supported: this is not model exchange",
            "fmi2CancelStep: not supported: canRunAsynchronuously is false",
        ]
    );
    free(instance);
}

#[test]
fn other_interface_types_give_null_and_a_log_line() {
    let token = CString::new(MODELS[0].instantiation_token()).unwrap();
    let mut lines = Lines::default();
    let environment = (&raw mut lines).cast();
    let name = c"probe".as_ptr();
    // SAFETY: the texts are terminated and the callback fits the environment.
    unsafe {
        let token = token.as_ptr();
        let (log, none) = (Some(log as _), null());
        assert!(
            fmi3::fmi3InstantiateModelExchange(name, token, none, false, true, environment, log)
                .is_null()
        );
        let scheduled = fmi3::fmi3InstantiateScheduledExecution(
            name,
            token,
            none,
            false,
            true,
            environment,
            log,
            None,
            None,
            None,
        );
        assert!(scheduled.is_null());
    }
    let said = lines.0.iter().map(|(_, line)| line.contains("is not supported"));
    assert_eq!(said.collect::<Vec<_>>(), [true, true], "{:?}", lines.0);
}

#[test]
fn a_panic_is_reported_once_and_the_instance_stays_lost() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    let (reference, yes) = (PANIC_NOW, true);
    // SAFETY: the arrays have one element each.
    unsafe {
        let status = fmi3::fmi3SetBoolean(instance, &raw const reference, 1, &raw const yes, 1);
        assert_eq!(status, OK);
    }
    assert_eq!((step(instance, 0.0, 1.0), step(instance, 0.0, 1.0)), (FATAL, FATAL));
    assert!(lines.0[0].1.contains("the model panicked: told to panic"), "{:?}", lines.0);
    assert_eq!(lines.0.iter().map(|(status, _)| *status).collect::<Vec<_>>(), [FATAL, FATAL]);
    free(instance);
}

#[test]
fn a_blank_name_or_a_missing_token_gives_no_instance() {
    let mut lines = Lines::default();
    assert!(instantiate_with("not a token", &mut lines).is_null());
    let environment = (&raw mut lines).cast();
    // SAFETY: the texts are null or terminated and the callback fits the environment.
    let instantiate = |name: *const c_char, token: *const c_char| unsafe {
        fmi3::fmi3InstantiateCoSimulation(
            name,
            token,
            null(),
            false,
            true,
            false,
            false,
            null(),
            0,
            environment,
            Some(log),
            None,
        )
    };
    assert!(instantiate(c"probe".as_ptr(), null()).is_null());
    assert!(instantiate(c" \t".as_ptr(), null()).is_null());
    assert!(instantiate(null(), null()).is_null());
    assert_eq!(lines.0.len(), 4, "{:?}", lines.0);
}

#[test]
fn communication_points_may_be_off_by_rounding_and_no_more() {
    let mut lines = Lines::default();
    let instance = running(&mut lines);
    let h = 1.0 / 300.0;
    for k in 0..3_000_i64 {
        // Times in whole nanoseconds, as a clock that counts them would give.
        let t_ns = (k * 1_000_000_000 + 150) / 300;
        #[expect(clippy::cast_precision_loss, reason = "ten seconds in nanoseconds are exact")]
        let t_s = t_ns as f64 / 1e9;
        assert_eq!(step(instance, t_s, h), OK, "step {k}: {:?}", lines.0);
    }
    assert_eq!(step(instance, 10.0 + 1e-8, h), ERROR);
    assert_eq!(step(instance, 10.0, h), OK);
    free(instance);
}

#[test]
fn model_descriptions_escape_what_xml_cannot_hold() {
    for version in FmiVersion::ALL {
        let xml = MODELS[0].model_description_xml(version);
        assert!(
            xml.contains("Rate &amp; sign; is &quot;integrated&quot; &lt;exactly&gt;."),
            "{xml}"
        );
        assert_eq!(xml, MODELS[0].model_description_xml(version), "{version} is not repeatable");
    }
}
