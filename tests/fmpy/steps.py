"""Runs steps through FMPy's low-level interface and writes the outputs as raw doubles.

Arguments: FMU, step size, file of inputs (rate, validity and clipping per step), file for outputs,
and parameters as name=value. An FMU that cannot be told of clipping is not.
"""

import sys
from pathlib import Path

from slave import Slave, bits, inputs_of, outputs_of, read_doubles, unpacked

fmu, step_size, inputs, outputs, *parameters = sys.argv[1:]
h = float(step_size)
doubles = read_doubles(inputs)
rows = list(zip(doubles[0::3], doubles[1::3], doubles[2::3]))
assert rows, "no inputs"

with unpacked(fmu) as (description, folder):
    slave = Slave(description, folder)
    outputs_there = outputs_of(description)
    tells_clipping = "measured_rate_over_range" in inputs_of(description)
    number = {
        "Real": float, "Float64": float, "Integer": int, "Int32": int,
        "Boolean": lambda text: text == "true",
    }
    values = dict(p.split("=") for p in parameters)
    slave.begin(**{n: number[slave.variables[n].type](v) for n, v in values.items()})
    record = bytearray(bits(slave.get(*outputs_there)))
    for k, (rate, valid, clipped) in enumerate(rows):
        slave.set(measured_rate_rad_s=rate, measured_rate_valid=valid != 0.0)
        if tells_clipping:
            slave.set(measured_rate_over_range=clipped != 0.0)
        slave.step(k, h)
        record += bits(slave.get(*outputs_there))
    slave.fmu.terminate()
    assert slave.log == [], slave.log
    slave.free()

Path(outputs).write_bytes(record)
