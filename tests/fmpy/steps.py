"""Runs steps through FMPy's low-level interface and writes the outputs as raw doubles.

Arguments: FMU, step size, file of inputs (rate and validity per step), file for outputs, and
parameters as name=value.
"""

import sys
from pathlib import Path

from slave import OUTPUTS, Slave, bits, read_doubles, unpacked

fmu, step_size, inputs, outputs, *parameters = sys.argv[1:]
h = float(step_size)
doubles = read_doubles(inputs)
rows = list(zip(doubles[0::2], doubles[1::2]))
assert rows, "no inputs"

with unpacked(fmu) as (description, folder):
    slave = Slave(description, folder)
    number = {"Real": float, "Float64": float, "Integer": int, "Int32": int}
    values = dict(p.split("=") for p in parameters)
    slave.begin(**{n: number[slave.variables[n].type](v) for n, v in values.items()})
    record = bytearray(bits(slave.get(*OUTPUTS)))
    for k, (rate, valid) in enumerate(rows):
        slave.set(measured_rate_rad_s=rate, measured_rate_valid=valid != 0.0)
        slave.step(k, h)
        record += bits(slave.get(*OUTPUTS))
    slave.fmu.terminate()
    assert slave.log == [], slave.log
    slave.free()

Path(outputs).write_bytes(record)
