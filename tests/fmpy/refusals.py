"""Whatever an importer does wrong is refused with a status and a log line, and changes nothing."""

import math
import sys

from slave import ERROR, Slave, bits, inputs_of, outputs_of, unpacked

H = 1 / 128  # exact in binary, so that times in log lines are too


def before_initialization(description, folder):
    slave = Slave(description, folder)
    refused = slave.refused
    refused(ERROR, ["before initialization mode"], slave.step, 0, H)
    refused(ERROR, ["has not been entered"], slave.fmu.exitInitializationMode)
    refused(ERROR, ["running model"], slave.fmu.terminate)
    refused(ERROR, ["before initialization mode"], slave.get, "angle_rad")
    slave.free()


BAD = {
    "measurement_variance_rad2_s2": (0.0, "= 0 "),
    "angle_variance_start_rad2": (-1.0, "= -1.0 "),
    "rate_variance_start_rad2_s2": (-2.0, "= -2.0 "),
    "process_noise_rad2_s3": (-3.0, "= -3.0 "),
    "refinement_samples": (-4, "= -4 "),
    "refinement_reading": (3, "= 3 "),
    "angle_sigma_start_rad": (-1.0, "= -1.0 "),
    "rate_sigma_start_rad_s": (-2.0, "= -2.0 "),
    "period_start_s": (1e13, "= 10000000000000 "),
    "period_sigma_start_s": (-1.5, "= -1.5 "),
    "damping_ratio_start": (-0.5, "= -0.5 "),
    "damping_ratio_sigma_start": (-0.25, "= -0.25 "),
    "bias_sigma_start_rad_s": (-1.0, "= -1.0 "),
    "bias_walk_rad2_s3": (-1.0, "= -1.0 "),
    "scale_factor_sigma": (-1.0, "= -1.0 "),
    "gyro_range_rad_s": (-1.0, "= -1.0 "),
    "test_false_alarms": (1.0, "= 1 "),
    "test_horizon_samples": (2047, "= 2047 "),
    "test_kick_floor_rad_s": (-1.0, "= -1.0 "),
    "sample_period_s": (0.0, "= 0 "),
    "gyro_count_rad_s": (-1.0, "= -1.0 "),
    "gyro_raw_sigma_rad_s": (-1.0, "= -1.0 "),
    "gyro_samples": (0, "= 0 "),
    "swing_max_rad": (1.625, "= 1.625 "),
    "fit_work_per_sample": (0, "= 0 "),
    "body_mass_kg": (-1.0, "= -1.0 "),
    "body_com_depth_m": (-1.0, "= -1.0 "),
    "body_inertia_x_kg_m2": (-1.0, "= -1.0 "),
    "body_inertia_y_kg_m2": (-1.0, "= -1.0 "),
    "body_inertia_z_kg_m2": (-1.0, "= -1.0 "),
    "body_inertia_sigma": (-1.0, "= -1.0 "),
    "body_swing_damping_1_s": (-1.0, "= -1.0 "),
    "body_swing_damping_sigma": (-1.0, "= -1.0 "),
    "gravity_m_s2": (-1.0, "= -1.0 "),
    "input_axis_sigma_rad": (-1.0, "= -1.0 "),
}
# Sound by themselves: anything finite, or either of two.
FREE = {
    "angle_start_rad", "rate_start_rad_s", "bias_start_rad_s", "gyro_range_margin_rad_s",
    "innovation_test", "input_axis_x_rad", "input_axis_y_rad", "measured_rate_is_mean",
}


def bad_parameters(description, folder):
    slave = Slave(description, folder)
    parameters = {n for n, v in slave.variables.items() if v.causality == "parameter"}
    bad = {name: BAD[name] for name in parameters & BAD.keys()}
    if "period_s" in parameters:
        bad["period_s"] = (0.0, "= 0 ")
    assert parameters - bad.keys() <= FREE, parameters - bad.keys()
    for name, (value, shown) in bad.items():
        slave.fmu.reset()
        slave.refused(ERROR, [name + " " + shown], slave.begin, **{name: value})
        assert "xitInitializationMode" in slave.log[-1][2], slave.log[-1]
    if "gyro_range_rad_s" in parameters:
        slave.fmu.reset()
        margin = {"gyro_range_rad_s": 0.5, "gyro_range_margin_rad_s": 0.5}
        slave.refused(ERROR, ["gyro_range_margin_rad_s = 0.5 "], slave.begin, **margin)
    if "body_mass_kg" in parameters:
        # A body that is declared is judged as a whole.
        body = {
            "body_mass_kg": 1.0, "body_com_depth_m": 0.1, "body_inertia_x_kg_m2": 0.01,
            "body_inertia_y_kg_m2": 0.011, "body_inertia_z_kg_m2": 0.012,
        }
        for name in list(body)[1:] + ["gravity_m_s2"]:
            slave.fmu.reset()
            slave.refused(ERROR, [name + " = 0 "], slave.begin, **{**body, name: 0.0})
        slave.fmu.reset()
        slave.refused(ERROR, ["input_axis_x_rad = 0.75 "], slave.begin, **body, input_axis_x_rad=0.75)
        slave.fmu.reset()
        slave.begin(**body)
    slave.free()


def in_step_mode(description, folder):
    outputs_there = outputs_of(description)
    slave = Slave(description, folder)
    slave.begin(start=0.0, stop=1.0)
    for k in range(10):
        slave.set(measured_rate_rad_s=0.02)
        slave.step(k, H)
    outputs = bits(slave.get(*outputs_there))
    refused = slave.refused

    refused(ERROR, ["angle_rad = 1.0", "output"], slave.set, angle_rad=1.0)
    refused(ERROR, ["angle_start_rad = 1.5", "fixed"], slave.set, angle_start_rad=1.5)
    for name in slave.variables.keys() & {"refinement_samples", "test_horizon_samples"}:
        refused(ERROR, [f"{name} = 7", "fixed"], slave.set, **{name: 7})
    refused(ERROR, ["time = 3.0", "independent"], slave.set, time=3.0)
    for value in (math.nan, math.inf, -math.inf):
        name = "measured_rate_rad_s"
        refused(ERROR, [name, "not finite"], slave.set, **{name: value})
    set_real = slave.fmu.setReal if slave.is_fmi2 else slave.fmu.setFloat64
    refused(ERROR, ["value reference 99"], set_real, [1, 99], [0.5, 0.5])
    refused(ERROR, ["measured_rate_valid", "Boolean"], set_real, [2], [0.5])

    now = 10 * H
    refused(ERROR, ["0.078125 s", "0.2 s"], slave.fmu.doStep, 0.2, H)
    refused(ERROR, ["communication point"], slave.fmu.doStep, math.nan, H)
    for h in (0.0, -H, math.nan, math.inf):
        refused(ERROR, ["step size"], slave.fmu.doStep, now, h)
    refused(ERROR, ["stop time 1"], slave.fmu.doStep, now, 0.95)
    refused(ERROR, ["initialization"], slave.fmu.enterInitializationMode)

    assert bits(slave.get(*outputs_there)) == outputs, "a refused call changed an output"
    assert slave.get("measured_rate_rad_s") == [0.02], "a refused set changed the input"
    slave.step(10, H)
    straight = Slave(description, folder)
    straight.begin(start=0.0, stop=1.0)
    for k in range(11):
        straight.set(measured_rate_rad_s=0.02)
        straight.step(k, H)
    same = bits(slave.get(*outputs_there)) == bits(straight.get(*outputs_there))
    assert same, "a refused call changed the state"

    slave.fmu.terminate()
    refused(ERROR, ["after termination"], slave.step, 11, H)
    refused(ERROR, ["after termination"], slave.set, measured_rate_rad_s=0.5)
    slave.get(*outputs_there)
    slave.free()
    straight.free()


def a_step_refused_half_way(description, folder, flag=None):
    """The prediction succeeds and the update overflows: neither may leave a trace."""
    slave = Slave(description, folder)
    slave.begin()
    slave.set(measured_rate_rad_s=0.02)
    slave.step(0, 64.0)
    outputs = bits(slave.get(*outputs_of(description)))
    state = slave.fmu.getFMUState()
    before = slave.fmu.serializeFMUState(state)
    slave.set(measured_rate_rad_s=1e308, **({flag: True} if flag else {}))
    slave.refused(ERROR, ["floating point"], slave.step, 1, 64.0)
    slave.set(measured_rate_rad_s=0.02, **({flag: False} if flag else {}))
    assert bits(slave.get(*outputs_of(description))) == outputs, "outputs moved"
    state = slave.fmu.getFMUState()
    assert slave.fmu.serializeFMUState(state) == before, "the state moved"
    slave.free()


def wrong_token(description, folder):
    slave = Slave(description, folder, token="0" * 64)
    assert not slave.fmu.component, "a wrong token was accepted"
    [(status, category, message)] = slave.log
    assert (status, category) == (ERROR, "logStatusError"), slave.log
    assert "nstantiat" in message and "0" * 64 in message, message
    assert description.guid in message, "the log line names the token expected"


def logging(description, folder):
    slave = Slave(description, folder)
    wrong = lambda: slave.step(0, H)
    slave.refused(ERROR, [], wrong)
    lines = len(slave.log)
    for on, categories, logged in [
        (False, [], False),
        (True, ["logStatusFatal"], False),
        (True, ["logStatusError"], True),
        (False, ["logStatusError"], False),
        (True, [], True),
    ]:
        slave.fmu.setDebugLogging(on, categories)
        try:
            wrong()
        except Exception:
            lines += logged
        assert len(slave.log) == lines, f"{on} {categories}: {slave.log}"
    slave.refused(ERROR, ["noSuchCategory"], slave.fmu.setDebugLogging, True, ["noSuchCategory"])
    slave.refused(ERROR, [], wrong)  # the refused call left logging as it was
    slave.free()

    silent = Slave(description, folder, logging_on=False)
    try:
        silent.step(0, H)
    except Exception:
        pass
    assert silent.log == [], silent.log
    silent.free()


with unpacked(sys.argv[1]) as (description, folder):
    before_initialization(description, folder)
    bad_parameters(description, folder)
    in_step_mode(description, folder)
    a_step_refused_half_way(description, folder)
    if "measured_rate_over_range" in inputs_of(description):
        a_step_refused_half_way(description, folder, "measured_rate_over_range")
    wrong_token(description, folder)
    logging(description, folder)
