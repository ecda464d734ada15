"""
Toggle press
============

Near its stretched position a toggle turns a small torque into a large force. Joint E has
an oil film and rough surfaces. ``clearance new toggle`` writes this machine.
"""

from pathlib import Path

import clearance as cl

press = Path(cl.__file__).parent / "scene" / "templates" / "toggle.toml"
run = cl.simulate(cl.load_case(press), turns=2)
run.plot.sketch()

# %%
# The force in joint E, and the torque that the crank needs for it:

run.plot.history("E.force,crank.torque", along="angle", last=1)

# %%
force, torque = run.extreme("joints/E/force_max"), run.extreme("drives/crank/torque_max")
print(f"largest force {force.value:.0f} N, largest torque {torque.value:.1f} N m")
