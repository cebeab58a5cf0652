"""Runs FMPy's `simulate_fmu` with an input array and writes the outputs as raw doubles.

Arguments: FMU, step size (a power of two, so that FMPy's times are exact), file of inputs (rate
and validity per step), file for outputs.
"""

import sys
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

from slave import OUTPUTS

fmu, step_size, inputs, outputs = sys.argv[1:]
h = float(step_size)
rows = np.fromfile(inputs, dtype="<f8").reshape(-1, 2)
steps = len(rows)

signals = np.zeros(
    steps,
    dtype=[("time", float), ("measured_rate_rad_s", float), ("measured_rate_valid", bool)],
)
signals["time"] = np.arange(steps) * h
signals["measured_rate_rad_s"] = rows[:, 0]
signals["measured_rate_valid"] = rows[:, 1] != 0.0

result = simulate_fmu(
    fmu, fmi_type="CoSimulation", stop_time=steps * h, output_interval=h, input=signals,
    output=OUTPUTS,
)
assert len(result) == steps + 1, f"{len(result)} rows for {steps} steps"
columns = np.stack([result[name] for name in OUTPUTS], axis=1)
Path(outputs).write_bytes(columns.astype("<f8").tobytes())
