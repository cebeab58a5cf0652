"""MuJoCo's default integrator on the string-suspended body, torsion included: where does it end?

Arguments: step in s, number of steps, stiffness of the string in N m/rad, twist in rad, attitude
(w, x, y, z) and body rate in rad/s at the start. Says "mujoco VERSION", or "missing" when it is not
installed, and then the attitude at the end.

MuJoCo has no torsion about the twist, so a passive force in Python provides it. That is slow, and
therefore no measure of MuJoCo's speed; `mujoco_rk4.py` measures that, without torsion.
"""

import math
import sys

try:
    import mujoco
except ImportError:
    print("missing")
    sys.exit()

import mujoco_body


def main():
    step_s, steps, stiffness, twist, *start = [float(number) for number in sys.argv[1:]]
    model, data = mujoco_body.start(mujoco, step_s, start)

    def string(_model, data):
        """-k tau (gamma + e3)/(1 + gamma3), with the twist unwrapped from call to call."""
        nonlocal twist
        w, x, y, z = data.qpos[2:6]
        twist += math.remainder(2.0 * math.atan2(z, w) - twist, 2.0 * math.pi)
        upright = 1.0 - 2.0 * (x * x + y * y)
        torque = -stiffness * twist / (1.0 + upright)
        gamma_x, gamma_y = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x)
        data.qfrc_passive[2:5] += [torque * gamma_x, torque * gamma_y, -stiffness * twist]

    mujoco.set_mjcb_passive(string)
    for _ in range(int(steps)):
        mujoco.mj_step(model, data)
    mujoco.set_mjcb_passive(None)
    print("mujoco", mujoco.__version__)
    print(*(float(number) for number in data.qpos[2:6]))


main()
