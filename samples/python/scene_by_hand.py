"""A scene by hand: a double pendulum; its equations at a state, a control law in Python, its motion."""
import numpy as np

import borelli

scene = borelli.Scene.from_toml(
    """
    name = "double pendulum"
    [[solid]]
    name = "upper"
    joint = {rotation = "y", name = "shoulder", value_deg = 30}
    mass = 2
    centre = [0, 0, -0.5]
    tensor = [0.1, 0.1, 0.01]
    [[solid]]
    name = "lower"
    parent = "upper"
    joint = [{fixed = [0, 0, -1]}, {rotation = "y", name = "elbow"}]
    mass = 1
    centre = [0, 0, -0.4]
    tensor = [0.05, 0.05, 0.01]
    """
)
system = borelli.System(scene)
state = system.state()
print(system.names, "start at", state.q)
print("mass matrix\n", system.mass_matrix(state))

# forces that hold it still: the accelerations under them vanish
hold = system.inverse_dynamics(state, np.zeros(system.n_v))
print("held by", hold, "N m; then it accelerates by", system.accelerations(state, hold))

# state is a view: the array is the state
state.v[:] = [1, -1]
motion = borelli.simulate(system, state=state, duration=2, accuracy=1e-8)
energy = motion.kinetic + motion.potential
print(f"{len(motion)} rows; energy keeps within {np.ptp(energy):.1e} J; trusted: {motion.trusted}")
