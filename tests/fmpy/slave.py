"""One face for FMPy's low-level FMI 2.0 and 3.0 co-simulation slaves."""

import ctypes
import shutil
import struct
from contextlib import contextmanager
from pathlib import Path

import fmpy
from fmpy import fmi2, fmi3
from fmpy.fmi1 import FMICallException
from fmpy.logging import addLoggerProxy

ERROR, FATAL = 3, 4
# Slaves by the environment pointer that each passes at instantiation. Log lines find their slave
# by nothing else, so one that does not bring the pointer back is lost and its test fails.
SLAVES = {}


def log_message(environment, status, category, message):
    SLAVES[environment].log.append((status, category.decode(), message.decode()))


def logger2(environment, _name, status, category, message):
    log_message(environment, status, category, message)


CALLBACKS2 = fmi2.fmi2CallbackFunctions()
CALLBACKS2.logger = fmi2.fmi2CallbackLoggerTYPE(logger2)
CALLBACKS2.allocateMemory = fmi2.defaultCallbacks.allocateMemory
CALLBACKS2.freeMemory = fmi2.defaultCallbacks.freeMemory
# Formats the variadic arguments in C. It knows one logger per process, the last one added.
addLoggerProxy(ctypes.byref(CALLBACKS2))
LOG_MESSAGE3 = fmi3.fmi3LogMessageCallback(log_message)


@contextmanager
def unpacked(fmu):
    """Unpacks an FMU for a while and gives its model description and folder."""
    folder = fmpy.extract(fmu)
    try:
        yield fmpy.read_model_description(fmu), folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class Slave:
    """An instance of an FMU that keeps its log lines as (status, category, message)."""

    def __init__(self, description, folder, logging_on=True, token=None):
        self.log = []
        self.environment = 0x5EED + len(SLAVES)
        SLAVES[self.environment] = self
        self.is_fmi2 = description.fmiVersion == "2.0"
        self.variables = {v.name: v for v in description.modelVariables}
        kind = fmi2.FMU2Slave if self.is_fmi2 else fmi3.FMU3Slave
        self.fmu = kind(
            guid=token or description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="slave",
        )
        instantiate = self._instantiate2 if self.is_fmi2 else self._instantiate3
        self.fmu.component = instantiate(logging_on)

    # FMPy's own `instantiate` passes no environment.

    def _instantiate2(self, logging_on):
        callbacks = fmi2.fmi2CallbackFunctions.from_buffer_copy(CALLBACKS2)
        callbacks.componentEnvironment = self.environment
        return self.fmu.fmi2Instantiate(
            b"slave", fmi2.fmi2CoSimulation, self.fmu.guid.encode(), b"",
            ctypes.byref(callbacks), False, logging_on,
        )

    def _instantiate3(self, logging_on):
        return self.fmu.fmi3InstantiateCoSimulation(
            b"slave", self.fmu.guid.encode(), None, False, logging_on, False, False, None, 0,
            self.environment, LOG_MESSAGE3, fmi3.fmi3IntermediateUpdateCallback(),
        )

    def _accessor(self, verb, name):
        kind = self.variables[name].type  # "Float64" and "Int32" in FMI 3.0
        return getattr(self.fmu, verb + kind)

    def get(self, *names):
        return [self._accessor("get", n)([self.variables[n].valueReference])[0] for n in names]

    def set(self, **values):
        for name, value in values.items():
            self._accessor("set", name)([self.variables[name].valueReference], [value])

    def begin(self, start=0.0, stop=None, **values):
        """Initialises with the given parameters and inputs."""
        if self.is_fmi2:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.set(**values)
            self.fmu.enterInitializationMode()
        else:
            self.set(**values)
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)
        self.fmu.exitInitializationMode()

    def step(self, k, h):
        """The step from k·h to (k + 1)·h."""
        self.fmu.doStep(k * h, h)

    def refused(self, status, needles, call, *arguments, **keywords):
        """Asserts that a call is refused with `status` and a log line that names `needles`."""
        before = len(self.log)
        try:
            call(*arguments, **keywords)
        except FMICallException as exception:
            assert exception.status == status, f"status {exception.status}, expected {status}"
            assert len(self.log) == before + 1, f"expected one log line: {self.log[before:]}"
            logged_status, category, message = self.log[-1]
            assert logged_status == status, self.log[-1]
            expected = {ERROR: "logStatusError", FATAL: "logStatusFatal"}[status]
            assert category == expected, self.log[-1]
            for needle in (exception.function, *needles):
                assert needle in message, f"{needle!r} is not in {message!r}"
        else:
            raise AssertionError(f"{call} was not refused")

    def free(self):
        self.fmu.freeInstance()


def read_doubles(path):
    """Little-endian doubles of a file."""
    content = Path(path).read_bytes()
    return list(struct.unpack(f"<{len(content) // 8}d", content))


def bits(values):
    """The exact bytes of some values, in which -0.0 and 0.0 differ."""
    return struct.pack(f"<{len(values)}d", *values)



# What every estimator has; some have more.
COMMON_OUTPUTS = [
    "angle_rad", "rate_rad_s", "angle_sigma_rad", "rate_sigma_rad_s", "innovation_rad_s", "nis",
]


def outputs_of(description):
    """Names of all outputs, in the order of the variable table."""
    names = [v.name for v in description.modelVariables if v.causality == "output"]
    assert names[:len(COMMON_OUTPUTS)] == COMMON_OUTPUTS, names
    return names


def inputs_of(description):
    """Names of all inputs."""
    return [v.name for v in description.modelVariables if v.causality == "input"]
