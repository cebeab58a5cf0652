"""A panic ends its instance and nothing else; all types and roles work; refusals change nothing."""

import sys

from slave import ERROR, FATAL, Slave, unpacked

H = 0.125


def types_and_roles(description, folder):
    slave = Slave(description, folder)
    slave.begin(angle_start_rad=1.0, count_start=-7, increment=3, rate_rad_s=2.0)
    assert slave.get("angle_rad", "count", "odd") == [1.0, -7, True]
    slave.step(0, H)
    assert slave.get("angle_rad", "count", "odd", "time") == [1.25, -4, False, H]
    slave.set(gain=2.0)  # tunable: may change between steps
    slave.refused(ERROR, ["gain = 2.5", "0.0 to 2.0"], slave.set, gain=2.5)
    slave.refused(ERROR, ["increment = 10", "-9 to 9"], slave.set, increment=10)
    slave.refused(ERROR, ["reversed = true", "fixed"], slave.set, reversed=True)
    slave.step(1, H)
    assert slave.get("angle_rad", "count", "odd") == [1.75, -1, True]

    slave.set(refuse_now=True)
    slave.refused(ERROR, ["told to refuse"], slave.step, 2, H)
    assert slave.get("angle_rad", "count", "time") == [1.75, -1, 2 * H], "a refused step moved on"
    slave.set(refuse_now=False)
    slave.step(2, H)
    assert slave.get("count") == [2]
    slave.free()

    slave = Slave(description, folder)
    slave.refused(ERROR, ["count_start = 13", "unlucky"], slave.begin, count_start=13)
    slave.set(count_start=12)
    assert slave.get("count") == [12], "outputs can be tried in initialization mode"
    slave.fmu.exitInitializationMode()
    slave.free()


def panic(description, folder):
    witness = Slave(description, folder)
    witness.begin()
    lost = Slave(description, folder)
    lost.begin()
    state = lost.fmu.getFMUState()
    lost.set(panic_now=True)
    lost.refused(FATAL, ["told to panic at count -6"], lost.step, 0, H)
    for call, arguments in [
        (lost.step, (0, H)),
        (lost.get, ("angle_rad",)),
        (lost.fmu.setFMUState, (state,)),
        (lost.fmu.reset, ()),
        (lost.fmu.terminate, ()),
    ]:
        lost.refused(FATAL, ["lost in an earlier panic"], call, *arguments)
    witness.step(0, H)
    assert witness.get("count") == [-6], "another instance was touched"
    component = lost.fmu.component
    lost.fmu.freeLibrary = lambda: None
    lost.free()
    # A freed handle is refused without being followed.
    lost.fmu.component = component
    try:
        lost.fmu.reset()
    except Exception as exception:
        assert exception.status == ERROR, exception
    else:
        raise AssertionError("a freed instance was reset")
    witness.free()


with unpacked(sys.argv[1]) as (description, folder):
    types_and_roles(description, folder)
    panic(description, folder)
