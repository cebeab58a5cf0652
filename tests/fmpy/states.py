"""Saved, serialized and reset states continue bit for bit; spoilt ones are refused.

Arguments: FMU, another model's FMU of the same FMI version.
"""

import ctypes
import math
import sys

from slave import ERROR, Slave, bits, inputs_of, outputs_of, unpacked

H = 0.01


def run(slave, first, last):
    """Steps first..last; the outputs after each, as bytes."""
    record = bytearray()
    for k in range(first, last):
        slave.set(measured_rate_rad_s=0.1 * math.sin(0.3 * k), measured_rate_valid=k % 7 != 3)
        if "measured_rate_over_range" in slave.inputs:
            slave.set(measured_rate_over_range=k % 13 == 5)
        slave.step(k, H)
        record += bits(slave.get(*slave.outputs))
    return bytes(record)


def started(description, folder):
    """An instance that knows its inputs and outputs, still to be initialised."""
    slave = Slave(description, folder)
    slave.inputs, slave.outputs = inputs_of(description), outputs_of(description)
    return slave


def parameters_of(slave):
    own = {"refinement_samples": 5, "period_start_s": 5.0}
    return {"angle_start_rad": 0.5, **{n: v for n, v in own.items() if n in slave.variables}}


def check(description, folder, foreign):
    slave = started(description, folder)
    fmu = slave.fmu
    parameters = parameters_of(slave)
    slave.begin(**parameters)
    before = run(slave, 0, 40)

    # A saved state brings back what steps have changed, as often as it is asked to.
    saved = fmu.getFMUState()
    straight = run(slave, 40, 120)
    for _ in range(2):
        fmu.setFMUState(saved)
        assert run(slave, 40, 120) == straight, "restored state runs differently"

    # So does its serialized form in another instance.
    serialized = fmu.serializeFMUState(saved)
    other = started(description, folder)
    state = other.fmu.deserializeFMUState(serialized)
    other.fmu.setFMUState(state)
    assert run(other, 40, 120) == straight, "serialized state runs differently"
    other.refused(ERROR, ["not saved by this instance"], other.fmu.setFMUState, saved)

    # Reset is a new start; saved states survive it.
    fmu.reset()
    names = ("angle_start_rad", "measured_rate_rad_s", "measured_rate_valid", "time")
    assert slave.get(*names) == [0.0, 0.0, True, 0.0], "reset kept a value"
    slave.begin(**parameters)
    assert run(slave, 0, 40) == before, "reset left something behind"
    fmu.setFMUState(saved)
    assert run(slave, 40, 120) == straight, "reset lost the saved state"

    # A freed state is recognised; null may be freed.
    fmu.freeFMUState(saved)
    slave.refused(ERROR, ["has been freed"], fmu.setFMUState, saved)
    fmu.freeFMUState(ctypes.c_void_p())

    # Spoilt bytes are refused, and the run goes on as if nothing had been.
    fmu.reset()
    slave.begin(**parameters)
    run(slave, 0, 40)
    refused = slave.refused
    # Every third byte of a small state; of one with a long history some forty, evenly spread.
    for place in range(0, len(serialized), max(3, len(serialized) // 40)):
        spoilt = bytearray(serialized)
        spoilt[place] ^= 0x40
        refused(ERROR, ["the serialized state is refused"], fmu.deserializeFMUState, bytes(spoilt))
    for length in (0, 1, 80, len(serialized) - 1):
        refused(ERROR, ["refused"], fmu.deserializeFMUState, serialized[:length])
    refused(ERROR, ["bytes long"], fmu.deserializeFMUState, serialized + b"\0")
    refused(ERROR, ["another model"], fmu.deserializeFMUState, foreign)
    assert run(slave, 40, 120) == straight, "a refused state changed something"

    slave.free()
    other.free()


with unpacked(sys.argv[2]) as (description, folder):
    slave = Slave(description, folder)
    slave.begin()
    foreign = slave.fmu.serializeFMUState(slave.fmu.getFMUState())
    slave.free()
with unpacked(sys.argv[1]) as (description, folder):
    check(description, folder, foreign)
