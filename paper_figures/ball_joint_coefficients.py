"""Bristle coefficients of a ball joint: constant, or functions of the speed.

Group: ball joint

Answers: Pfitzer et al., Lubricants 13 (2025) 436. Algorithm 1 (torque, stiffness and damping as
outputs of a network of the speed) and appendix K (constant sigma0 and sigma1).

Reproduced: 3-D LuGre with constant coefficients, with tables over four speeds and with a network of
two units, fitted to the same trials. Speed-dependent coefficients gain a little in training; beyond
the data networks are worse.

Assumed: the records (synthetic bench), the sizes of tables and networks, and the weights that keep
both smooth.

Not comparable: the source's networks, whose sizes we do not have, and the numbers of its appendix.
"""

import numpy as np
from clearance.paper_figures import ball_joint_variants as variants
from clearance.paper_figures import workshop
from clearance.paper_figures.ball_joint_bench import bench
from clearance.postprocess.figures import finish, sheet

STROKES = (
    {"color": "#d55e00", "ls": "-", "lw": 1.8},
    {"color": "#7b3294", "ls": "--", "lw": 1.4},
    {"color": "#2f7ec0", "ls": "-.", "lw": 1.4},
)
FUNCTIONS = ("T [N m]", "stiffness [N m/rad]", "damping [N m s/rad]")
SPIN, SEEN = 2, (0.0175, 0.873)  # rad/s: triangles of the training


def picture(rows):
    """T, sigma0 and sigma1 of spin over the speed, and the errors of all groups of trials."""
    figure = sheet(12.0, 6.6)
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 0.85))
    panels, bars = above.subplots(1, 3), below.subplots(1, 1)
    speeds = np.geomspace(2e-3, 8.0, 200)
    for f, style in zip(rows, STROKES, strict=True):
        functions = f.fit.model.functions(f.fit.values, speeds)[SPIN]
        for k, axes in enumerate(panels):
            axes.plot(speeds, functions[k], label=f.name, **style)
    panels[0].plot(
        speeds,
        variants.true_steady(speeds) - 0.05 * speeds,
        color="0.6",
        lw=4.0,
        zorder=0,
        label="truth",
    )
    for axes, name in zip(panels, FUNCTIONS, strict=True):
        axes.axvspan(*SEEN, color="0.93", zorder=-1)
        axes.set_xscale("log")
        axes.set_yscale("log" if name.startswith("damping") else "linear")
        finish(axes, name, "speed of spin [rad/s]; grey: training", legend=False)
        if not name.startswith("damping"):
            axes.set_ylim(0.0, None)
    groups = list(rows[0].nrmse)
    for k, (f, style) in enumerate(zip(rows, STROKES, strict=True)):
        where = np.arange(len(groups)) + 0.25 * (k - 1.0)
        drawn = bars.bar(where, [f.nrmse[g] for g in groups], 0.24, color=style["color"])
        bars.bar_label(drawn, fmt="%.2f", fontsize=8, padding=1)
    beyond = {"fast": "fast spin, tilt", "small": "small sines", "mixed": "mixed motion"}
    bars.set_xticks(range(len(groups)), [beyond.get(g, g) for g in groups])
    bars.margins(y=0.12)
    finish(bars, "rms error / rms torque [-]", "", legend=False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def draw(work: workshop.Workshop) -> None:
    rows = variants.coefficients(bench(), starts=work.less(variants.STARTS, 1), say=work.say)
    for f in rows:
        file = f"{f.name.replace(' ', '_')}.h5"
        work.study(lambda folder, f=f, file=file: f.fit.save(folder / file), coefficients=f.name)
    work.keep(picture(rows))
    work.text(variants.coefficient_table(rows))
