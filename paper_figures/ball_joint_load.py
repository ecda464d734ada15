"""Ball-joint friction under several preloads: one level, proportional to the preload, or a power of
it.

Group: ball joint

Answers: Pfitzer et al., Lubricants 13 (2025) 436, appendix J, the influence of the load.

Reproduced: records at several preloads, and 3-D LuGre fitted to all of them. Its level is fixed,
proportional or a power of the preload; the fit returns the exponent with its interval. One level
for all is wrong at every preload.

Assumed: the records. They are the synthetic bench under five preloads, whose elements follow the
preload to the power 0.85 (polymer liner), its grease not. There is no scatter from run to run,
which would hide the effect of the load at single preloads.

Not comparable: any number; appendix J was not at hand.
"""

import numpy as np
from clearance.paper_figures import ball_joint_variants as variants
from clearance.paper_figures import workshop
from clearance.paper_figures.ball_joint_bench import LOAD_EXPONENT, PRELOAD, Joint
from clearance.postprocess.figures import finish, legend_below, sheet

STYLE = {
    "fixed": {"color": "#00724f", "ls": "-.", "marker": "D"},
    "proportional": {"color": "#7b3294", "ls": "--", "marker": "s"},
    "power": {"color": "#d55e00", "ls": "-", "marker": "o"},
}
SPEED = 0.5  # rad/s, of the steady torques drawn


def picture(rows):
    """Steady torque and test error over the preload."""
    figure = sheet(10.0, 3.9)
    level, error = figure.subplots(1, 2)
    fine = np.linspace(1500.0, 13000.0, 60)
    joint = Joint()
    truth = (joint.torque[2] * (fine / PRELOAD) ** LOAD_EXPONENT) + joint.viscosity * SPEED
    level.plot(fine / 1e3, truth, color="0.6", lw=4.0, label="truth, warm joint")
    for f in rows:
        style = STYLE[f.load]
        torque, _, _, viscous = f.fit.model.functions(f.fit.values, np.array([SPEED]))[2, :, 0]
        exponent = {"fixed": 0.0, "proportional": 1.0}.get(f.load)
        exponent = f.fit.values["spin_load_exponent"] if exponent is None else exponent
        says = (torque + viscous * SPEED) * (fine / PRELOAD) ** exponent
        level.plot(fine / 1e3, says, color=style["color"], ls=style["ls"], label=f"LuGre, {f.load}")
        error.plot(
            [p / 1e3 for p in f.test], list(f.test.values()), **style, mfc="none", label=f.load
        )
    for axes in (level, error):
        for p in variants.SEEN:
            axes.axvline(p / 1e3, color="0.85", lw=5.0, zorder=0)
    level.set_title(f"steady torque of spin at {SPEED:g} rad/s", fontsize=10)
    error.set_title("test trials; grey: preloads that were fitted", fontsize=10)
    error.set_ylim(0.0, None)
    finish(level, "torque [N m]", "preload [kN]", legend=False)
    finish(error, "rms error / rms torque [-]", "preload [kN]", legend=False)
    legend_below(figure, level)
    return figure


def draw(work: workshop.Workshop) -> None:
    rows = variants.loads(starts=work.less(variants.STARTS, 1))
    for f in rows:
        work.study(
            lambda folder, f=f: f.fit.save(folder / f"{f.load}.h5"),
            load=f.load,
            preloads=variants.SEEN,
        )
    work.keep(picture(rows))
    work.text(variants.load_table(rows))
