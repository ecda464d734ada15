"""Bristles linearised: frequency response of LuGre friction beside the full law at several
amplitudes.

Group: ball joint

Answers: Pfitzer et al., Lubricants 13 (2025) 436, appendix A, the linearisation of the bristle, and
how small a motion has to be for it.

Reproduced: at rest the linear model is a spring and a damper, sigma0 + i omega (sigma1 + sigma2).
The full law meets it at a hundredth of the break-away angle. At that angle a fifth of its stiffness
is gone and the phase is 22 degrees. About steady sliding a slow small oscillation sees
the slope of the steady curve: a negative damping where it falls.

Assumed: the parameters: 3-D LuGre fitted to the synthetic bench; amplitudes and sliding speeds.

Not comparable: the numbers of the appendix, which was not at hand.
"""

import math

import numpy as np
from clearance.paper_figures import ball_joint_response as response
from clearance.paper_figures import workshop
from clearance.paper_figures.ball_joint_bench import bench
from clearance.postprocess.figures import finish, sheet

from clearance.identify.fit import fit

AMPLITUDES = (0.01, 0.3, 1.0, 3.0, 10.0)  # of the angle of break-away
RATES = (0.01, 0.04, 0.3)  # rad/s: before, on and behind the fall of the steady curve
SMALL = 0.02  # of the sliding rate: amplitude of the oscillating one
LINEAR = {"color": "0.65", "lw": 4.0, "zorder": 0}
COLOURS = ("#08306b", "#2f7ec0", "#00724f", "#d55e00", "#7b3294")


def picture(result, count: int):
    """Amplitude ratio and phase at rest; damping over the frequency about steady sliding."""
    figure = sheet(12.0, 4.6)
    ratio, phase, sliding = figure.subplots(1, 3)
    model, values = result.model, result.values
    frequencies = np.geomspace(0.1, 200.0, count)
    reach = values["spin_static"] / values["spin_stiffness"]
    linear = response.linear(model, values, frequencies)
    _draw(ratio, phase, frequencies, linear, "linearised", LINEAR)
    for share, colour in zip(AMPLITUDES, COLOURS, strict=True):
        g = response.whole(model, values, share * reach, frequencies)
        style = {"color": colour, "lw": 1.3}
        _draw(
            ratio,
            phase,
            frequencies,
            g,
            f"{share:g} of break-away ({math.degrees(share * reach):.2g} deg)",
            style,
        )
    for axes in (ratio, phase, sliding):
        axes.set_xscale("log")
    ratio.set_yscale("log")
    ratio.set_title("about rest: amplitude ratio", fontsize=10)
    finish(ratio, "torque over angle [N m/rad]", "frequency [Hz]", legend=False)
    phase.set_title("about rest: phase", fontsize=10)
    phase.set_yticks([0, 30, 60, 90])
    finish(phase, "torque before angle [deg]", "frequency [Hz]", legend=False)
    for rate, colour in zip(RATES, COLOURS[1::1], strict=False):
        turn = 2.0 * math.pi * frequencies
        sliding.plot(
            frequencies,
            response.linear(model, values, frequencies, rate=rate).imag / turn,
            **LINEAR,
        )
        pairs = [
            (
                f,
                response.whole(model, values, SMALL * rate / (2.0 * math.pi * f), [f], rate=rate)[
                    0
                ].imag,
            )
            for f in frequencies[::3]
        ]
        marks = np.array([(f, loss / (2.0 * math.pi * f)) for f, loss in pairs])
        sliding.plot(*marks.T, "o", ms=4, mfc="none", color=colour, label=f"{rate:g} rad/s")
    sliding.axhline(0.0, color="0.4", lw=0.8)
    sliding.set_yscale("symlog", linthresh=0.1)
    sliding.set_title("about steady sliding: damping", fontsize=10)
    finish(
        sliding, "loss moment / omega [N m s/rad]", "frequency [Hz]; grey: linearised", legend=False
    )
    sliding.legend(fontsize=8, frameon=False)
    handles, labels = ratio.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False)
    return figure


def _draw(ratio, phase, frequencies, g, label: str, style: dict) -> None:
    ratio.plot(frequencies, abs(g), label=label, **style)
    phase.plot(frequencies, np.degrees(np.angle(g)), **style)


def draw(work: workshop.Workshop) -> None:
    result = fit(bench(), "lugre3d", starts=work.less(5, 1))
    work.study(lambda folder: result.save(folder / "lugre3d.h5"), model="lugre3d", seed=0)
    work.keep(picture(result, work.less(40, 10)))
