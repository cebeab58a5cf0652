"""MuJoCo's RK4 on the string-suspended body, torsion included: one motion for each line of input.

A line holds a word and numbers, all SI: what the torsion acts about ("twist" or "vertical"), step,
duration, mass, depth of the centre of mass, gravity, three central moments, stiffness and damping
of the string, attitude (w, x, y, z), twist, body rate (x, y, z). The answer is one line: attitude
and twist at the end, in digits that read back to the same bits.

MuJoCo knows no torsion about the twist. It comes in through the passive callback, which MuJoCo
calls in every stage of every step. What is MuJoCo's own: inertia, gravity, the sliding point of
suspension, the gyroscopic torque, the kinematics and the integration.
"""

import math
import sys

import mujoco

# The point that the string holds slides in its plane; the body turns about it. The velocities of a
# ball joint are the body rate in body components, its forces a torque in body components.
MODEL = """
<mujoco>
  <option timestep="{step_s!r}" integrator="RK4" gravity="0 0 {minus_gravity!r}"/>
  <worldbody>
    <body>
      <joint type="slide" axis="1 0 0"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="ball"/>
      <inertial pos="0 0 {minus_depth!r}" mass="{mass!r}" diaginertia="{a!r} {b!r} {c!r}"/>
    </body>
  </worldbody>
</mujoco>
"""

# Nothing pushes the centre of mass sideways, so it stays where it is; what it does drift within a
# minute is the error of the integration, below 1e-10 m in the motions of the test.
DRIFT_MAX_M = 1e-9


class Unwrapped:
    """An angle that is known up to whole turns, followed from one value to the next."""

    def __init__(self, angle_rad):
        self.angle_rad = angle_rad

    def follow(self, wrapped_rad):
        self.angle_rad += math.remainder(wrapped_rad - self.angle_rad, math.tau)
        return self.angle_rad


def vertical(w, x, y, z):
    """The vertical in body components."""
    return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


def about_twist(stiffness, damping):
    """A thread soft in bending: torsion about the bisector of vertical and body axis."""

    def torque(q, rate, twist_rad):
        g1, g2, g3 = vertical(*q)
        twist_rate_rad_s = (rate[0] * g1 + rate[1] * g2) / (1.0 + g3) + rate[2]
        share = -(stiffness * twist_rad + damping * twist_rate_rad_s) / (1.0 + g3)
        return share * g1, share * g2, share * (1.0 + g3)

    return torque


def about_vertical(stiffness, _damping):
    """The misreading: a vertical torque that only the precession angle psi decides."""
    psi = Unwrapped(0.0)

    def torque(q, _rate, _twist_rad):
        w, x, y, z = q
        # Third column of the rotation: (sin psi sin theta, -cos psi sin theta, cos theta).
        psi.follow(math.atan2(2.0 * (x * z + w * y), -2.0 * (y * z - w * x)))
        return tuple(-stiffness * psi.angle_rad * share for share in vertical(*q))

    return torque


TORSIONS = {"twist": about_twist, "vertical": about_vertical}


def suspension_velocity(q, rate, depth):
    """Velocity (x, y) of the point of suspension that keeps the centre of mass from drifting."""
    w, x, y, z = q
    # rate x (0, 0, -depth) in body components, then its horizontal world components.
    u, v = -rate[1] * depth, rate[0] * depth
    along_x = (1.0 - 2.0 * (y * y + z * z)) * u + 2.0 * (x * y - w * z) * v
    along_y = 2.0 * (x * y + w * z) * u + (1.0 - 2.0 * (x * x + z * z)) * v
    return -along_x, -along_y


def centre_of_mass(model, data):
    """Horizontal place of the centre of mass."""
    mujoco.mj_kinematics(model, data)
    return data.xipos[1, :2].tolist()


def motion(torsion, numbers):
    """Attitude and twist at the end of a motion."""
    step_s, duration_s, mass, depth, gravity, a, b, c, stiffness, damping = numbers[:10]
    q, twist_rad, rate = numbers[10:14], numbers[14], numbers[15:18]
    model = mujoco.MjModel.from_xml_string(MODEL.format(
        step_s=step_s, minus_gravity=-gravity, minus_depth=-depth, mass=mass, a=a, b=b, c=c))
    assert (model.nq, model.nv) == (6, 5), "slide, slide, ball"
    data = mujoco.MjData(model)
    data.qpos[2:6] = q
    data.qvel[0:2] = suspension_velocity(q, rate, depth)
    data.qvel[2:5] = rate
    # Views into MuJoCo's own arrays: they stay valid, and cost less than asking each time.
    attitude, body_rate, joint_torque = data.qpos[2:6], data.qvel[2:5], data.qfrc_passive[2:5]
    twist, torque = Unwrapped(twist_rad), TORSIONS[torsion](stiffness, damping)

    def string(_model, _data):
        q, rate = attitude.tolist(), body_rate.tolist()
        joint_torque[:] = torque(q, rate, twist.follow(2.0 * math.atan2(q[3], q[0])))

    start = centre_of_mass(model, data)
    mujoco.set_mjcb_passive(string)
    mujoco.mj_step(model, data, nstep=round(duration_s / step_s))
    mujoco.set_mjcb_passive(None)
    assert abs(data.time - duration_s) < 1e-6, f"{data.time} s reached"
    drift = math.dist(start, centre_of_mass(model, data))
    assert drift < DRIFT_MAX_M, f"the centre of mass drifted by {drift} m"
    q = attitude.tolist()
    return *q, twist.follow(2.0 * math.atan2(q[3], q[0]))


def main():
    for line in sys.stdin:
        torsion, *numbers = line.split()
        print(*map(repr, motion(torsion, [float(number) for number in numbers])), flush=True)


main()
