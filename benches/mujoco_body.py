"""The reference body on a string without torsion, for MuJoCo."""

# The point that the string holds slides in its plane; the body turns about it.
MODEL = """
<mujoco>
  <option gravity="0 0 -9.81"/>
  <worldbody>
    <body>
      <joint type="slide" axis="1 0 0"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="ball"/>
      <inertial pos="0 0 -0.1" mass="1" diaginertia="0.0100 0.0110 0.0120"/>
    </body>
  </worldbody>
</mujoco>
"""


def start(mujoco, step_s, attitude_and_rate):
    """Model and data at the start: attitude (w, x, y, z), then the body rate in rad/s."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    model.opt.timestep = step_s
    data = mujoco.MjData(model)
    data.qpos[2:6] = attitude_and_rate[:4]
    data.qvel[2:5] = attitude_and_rate[4:]
    return model, data
