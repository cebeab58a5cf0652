"""The FMU is valid, and the unit in each variable's name is the unit that it declares."""

import sys
import xml.etree.ElementTree as xml
import zipfile

import fmpy
from fmpy.validation import validate_fmu

fmu = sys.argv[1]

problems = validate_fmu(fmu)
assert problems == [], problems

description = fmpy.read_model_description(fmu)
units = {u.name for u in description.unitDefinitions} - {"1"}
suffixes = {"_" + name.replace("/", "_").replace(".", "_"): name for name in units}
for variable in description.modelVariables:
    unit = variable.unit or (variable.declaredType and variable.declaredType.unit) or "1"
    if variable.causality == "independent":
        assert unit == "s", f"{variable.name} is in {unit}"
        continue
    # The longest suffix that fits: "rate_rad_s" also ends in "_s".
    fitting = [s for s in suffixes if variable.name.endswith(s)]
    named = suffixes[max(fitting, key=len)] if fitting else "1"
    assert named == unit, f"{variable.name} declares {unit}"
    if variable.type in ("Real", "Float64"):
        assert unit in units | {"1"}, f"{variable.name} has no defined unit"

with zipfile.ZipFile(fmu) as archive:
    root = xml.fromstring(archive.read("modelDescription.xml"))
if description.fmiVersion != "2.0":
    # The `fmi` crate rejects a unit on an FMI 3.0 variable; declared types carry it.
    for variable in root.find("ModelVariables"):
        assert "unit" not in variable.attrib, variable.attrib["name"]
categories = [c.attrib["name"] for c in root.find("LogCategories")]
assert categories == ["logStatusError", "logStatusFatal"], categories

# Outputs change in steps only, and each starts from the parameter of its own name.
starts = {u.variable.name: [d.name for d in u.dependencies] for u in description.initialUnknowns}
assert "angle_start_rad" in starts["angle_rad"], starts
if description.modelName != "Probe":
    assert starts["rate_rad_s"] == ["rate_start_rad_s"], starts
assert all(u.dependencies == [] for u in description.outputs), "an output follows an input at once"

capabilities = description.coSimulation
assert capabilities.canHandleVariableCommunicationStepSize
assert capabilities.canGetAndSetFMUstate and capabilities.canSerializeFMUstate
