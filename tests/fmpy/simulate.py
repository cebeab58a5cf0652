"""Runs FMPy's `simulate_fmu` with an input array and writes the outputs as raw doubles.

Arguments: FMU, step size (a power of two, so that FMPy's times are exact), file of inputs (rate,
validity and clipping per step), file for outputs.
"""

import sys
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu

from slave import inputs_of, outputs_of

fmu, step_size, inputs, outputs = sys.argv[1:]
h = float(step_size)
rows = np.fromfile(inputs, dtype="<f8").reshape(-1, 3)
steps = len(rows)
description = read_model_description(fmu)

columns = [
    ("measured_rate_rad_s", float), ("measured_rate_valid", bool),
    ("measured_rate_over_range", bool),
][:len(inputs_of(description))]
signals = np.zeros(steps, dtype=[("time", float), *columns])
signals["time"] = np.arange(steps) * h
for k, (name, kind) in enumerate(columns):
    signals[name] = rows[:, k].astype(kind)

names = outputs_of(description)
result = simulate_fmu(
    fmu, fmi_type="CoSimulation", stop_time=steps * h, output_interval=h, input=signals,
    output=names,
)
assert len(result) == steps + 1, f"{len(result)} rows for {steps} steps"
columns = np.stack([result[name] for name in names], axis=1)
Path(outputs).write_bytes(columns.astype("<f8").tobytes())
