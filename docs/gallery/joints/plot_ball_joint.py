"""
Friction of a ball joint
========================

A synthetic bench turns a preloaded ball joint. A LuGre law with bristles is fitted to its
training trials.
"""

import numpy as np
from clearance.paper_figures.ball_joint_bench import bench
from matplotlib.figure import Figure

from clearance.identify.fit import fit

data = bench(seed=0)
fitted = fit(data, "lugre1d")


def torque_over_angle(trial):
    """A trial of the bench beside the fit."""
    figure = Figure(figsize=(6, 4.5), layout="constrained")
    axes = figure.add_subplot(xlabel="angle [deg]", ylabel="torque [N m]", title=trial.name)
    angle = np.degrees(trial.angle[:, 2])
    axes.plot(angle, trial.torque[:, 2], color="0.6", label="bench")
    axes.plot(angle, fitted.torque(trial)[:, 2], label="fit")
    axes.legend()
    return figure


torque_over_angle(next(t for t in data.trials if t.role == "test" and t.measured[2]))

# %%
low, high = fitted.widened()  # 95 % intervals
for name in ("spin_static", "spin_stiffness"):
    print(f"{name} {fitted.values[name]:.4g}, {low[name]:.4g} to {high[name]:.4g}")
