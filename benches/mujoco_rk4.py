"""MuJoCo's RK4 on the string-suspended body, stepped in bursts on request.

Says "mujoco VERSION", or "missing" when it is not installed. Then, for every line with a number of
steps, does them in one native call and answers with their wall time in seconds and the vertical
component of the body axis at the end.

The string's torsion is left out: MuJoCo has no torsion about the twist, so it would take a Python
callback in every stage of every step, which costs ten to a hundred times the step itself.
"""

import sys
import time

try:
    import mujoco
except ImportError:
    print("missing", flush=True)
    sys.exit()

import mujoco_body


def main():
    print("mujoco", mujoco.__version__, flush=True)
    # Attitude (w, x, y, z) and body rate at the start, as the bench passes them.
    start = [float(number) for number in sys.argv[1:]]
    model, data = mujoco_body.start(mujoco, 1e-3, start)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    for line in sys.stdin:
        begun = time.perf_counter()
        mujoco.mj_step(model, data, nstep=int(line))
        taken_s = time.perf_counter() - begun
        _, x, y, _ = data.qpos[2:6]
        print(taken_s, 1.0 - 2.0 * (x * x + y * y), flush=True)


main()
