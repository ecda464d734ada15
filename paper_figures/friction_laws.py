"""Friction laws side by side: of joints without clearance, of clearance joints, and the loops of
LuGre.

Group: joints

Answers: Guo, Ju and Wang (2024), the two friction laws of their joints. Chacko and Khan (2017), the
combined breakaway, Coulomb and viscous law with its linear zone at rest. For clearance joints the
comparisons of friction laws over speed in the literature (Marques et al., Nonlinear Dyn. 86 (2016)
1407).

Reproduced: every law with the coefficients that its source prints. The value 24.995 N m at the
threshold of the linear zone fixes the decay coefficient as 10. Also hysteresis before sliding,
breakaway and the lag of the friction force of LuGre.

Assumed: the exponent of the Stribeck term (1 and 2 are drawn) and the breakaway rate 0.1 of the
smooth law. Also equal coefficients and speeds for all laws of clearance joints, and all parameters
of LuGre.

Not comparable: the measured Stribeck curve of Guo, Ju and Wang, of which we had no data.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.figures import finish, legend_below, line, sheet, stroke
from scipy.integrate import solve_ivp

import clearance as cl

#: joint friction of the two cases of Guo, Ju and Wang: rates drawn up to [rad/s], laws at unit load
GUO = {
    "case 1 of Guo, Ju and Wang": (
        0.2,
        {"coefficient": 0.005},
        {"static": 0.05, "stribeck_rate": 0.03},
    ),
    "case 2 of Guo, Ju and Wang": (
        0.4,
        {"coefficient": 0.05},
        {"static": 0.2, "stribeck_rate": 0.1},
    ),
}
CHACKO = {"breakaway": 25.0, "coulomb": 20.0, "viscous": 1e-3}
MIDDLE, SWING = 1.2e-2, 1.1e-2  # m/s: sliding whose speed goes up and down
BRISTLES = {
    "static": 0.12,
    "kinetic": 0.10,
    "stribeck_speed": 1e-2,
    "stiffness": 1e5,
    "damping": 10.0,
}
#: of clearance joints: static 0.12 where there is such a level, kinetic 0.10, rest and sliding
#: parted at 1 mm/s
MU = {"coefficient": 0.10}
CLEARANCE = {
    "coulomb, algebraic": cl.coulomb(**MU),
    "coulomb, tanh": cl.coulomb_tanh(**MU),
    "threlfall": cl.threlfall(**MU),
    "ambrosio": cl.ambrosio(**MU),
    "bengisu_akay": cl.bengisu_akay(static=0.12, kinetic=0.10),
    "stribeck": cl.stribeck(static=0.12, kinetic=0.10, stribeck_speed=1e-2, transition_speed=1e-3),
    "coulomb_viscous": cl.coulomb_viscous(**MU, viscous=0.02),
    "lugre, steady": None,
}


def draw(work: workshop.Workshop) -> None:
    work.keep(of_joints(), "joints")
    work.keep(of_clearance_joints(), "clearance_joints")
    work.keep(loops(), "lugre")


def of_joints():
    """Laws of hinges over their rate, with the numbers of their sources."""
    figure = sheet(9.0, 7.0)
    panels = figure.subplots(2, 2)
    for axes, (title, (end, level, falling)) in zip(panels[0], GUO.items(), strict=True):
        _guo(axes, end, level, falling)
        axes.set_title(title, fontsize="medium")
    legends = {"fontsize": "small", "frameon": False}
    panels[0, 0].legend(**legends, loc="lower right")
    for axes, end in zip(panels[1], (0.6, 4e-4), strict=True):
        rate = np.linspace(-end, end, 2001)
        linear = cl.breakaway_linear(**CHACKO, decay=10.0, threshold=1e-4)
        smooth = cl.breakaway_smooth(**CHACKO, breakaway_rate=0.1)
        line(
            axes,
            rate,
            -linear(rate, 0.0),
            label="breakaway, linear at rest",
            **stroke(1, 3),
            lw=1.4,
        )
        line(axes, rate, -smooth(rate, 0.0), label="breakaway, smooth", **stroke(2, 3), lw=1.4)
        finish(axes, "friction torque [N m]", "rate [rad/s]", legend=False)
    panels[1, 0].set_title("Chacko and Khan", fontsize="medium")
    panels[1, 1].set_title("the same near rest", fontsize="medium")
    panels[1, 1].ticklabel_format(axis="x", scilimits=(0, 0), useMathText=True)
    value = -cl.breakaway_linear(**CHACKO)(1e-4, 0.0)
    panels[1, 1].plot(
        1e-4, value, "o", ms=5, color="black", mfc="none", label=f"threshold: {value:.3f} N m"
    )
    panels[1, 1].legend(**legends, loc="lower right")
    return figure


def _guo(axes, end: float, level: dict, falling: dict) -> None:
    """Coulomb-viscous and Stribeck friction over the load, at rates up to `end`, without the
    viscous part.
    """
    rate = np.linspace(-end, end, 2001)
    laws = {"Coulomb": cl.joint_coulomb(**level)}
    for exponent in (2.0, 1.0):
        law = cl.joint_stribeck(kinetic=level["coefficient"], **falling, exponent=exponent)
        laws[f"Stribeck, exponent {exponent:g}"] = law
    for i, (name, law) in enumerate(laws.items()):
        line(
            axes,
            rate,
            -law(rate, 1.0),
            label=name,
            **(stroke(i, 3) | {"ls": ("-", "-", "--")[i]}),
            lw=1.4,
        )
    finish(axes, "friction / friction load [-]", "rate [rad/s]", legend=False)


def of_clearance_joints():
    """Laws of clearance joints over the sliding speed: near rest, and over decades of it."""
    figure = sheet(9.5, 5.0)
    near, wide = figure.subplots(1, 2, sharey=True)
    slow, decades = np.linspace(0.0, 4e-3, 801), np.geomspace(1e-5, 1.0, 801)
    for i, (name, law) in enumerate(CLEARANCE.items()):
        style = (stroke(i % 6, 6) | {"ls": ":" if i >= 6 else stroke(i % 6, 6)["ls"]}) | {
            "label": name,
            "lw": 1.5,
        }
        line(near, 1e3 * slow, _ratio(law, slow), **style)
        line(wide, decades, _ratio(law, decades), **style)
    wide.set_xscale("log")
    finish(near, "friction / normal force [-]", "sliding speed [mm/s]", legend=False)
    finish(wide, "", "sliding speed [m/s]", legend=False)
    legend_below(figure, near)
    return figure


def _ratio(law, speed: np.ndarray) -> np.ndarray:
    """Friction over the normal force; of bristles in steady sliding."""
    if law is not None:
        return -law(speed, 1.0)
    stuck, sliding, decay = (BRISTLES[n] for n in ("static", "kinetic", "stribeck_speed"))
    level = sliding + (stuck - sliding) * np.exp(-((speed / decay) ** 2))
    return np.where(speed > 0.0, level, 0.0)


def loops():
    """LuGre in clearance joints: loops before sliding, breaking away, and the lag behind the
    speed.
    """
    figure = sheet(11.0, 3.8)
    before, away, lag = figure.subplots(1, 3)
    for i, amplitude in enumerate((0.4e-6, 1.0e-6, 3.0e-6)):
        time, shift, _, friction = _moved(
            lambda t, a=amplitude: a * np.sin(t), lambda t, a=amplitude: a * np.cos(t)
        )
        last = time >= time[-1] - 2.0 * np.pi
        label = f"±{1e6 * amplitude:g} µm"
        line(
            before,
            1e6 * shift[last],
            friction[last],
            label=label,
            **(stroke(2 - i, 3) | {"lw": 1.4}),
        )
    finish(before, "friction / normal force [-]", "displacement [µm]\nbefore sliding, to and fro")
    for i, speed in enumerate((1e-4, 2e-3, 1e-2)):
        _, shift, _, friction = _moved(
            lambda t, v=speed: v * t, lambda t, v=speed: v + 0.0 * t, end=6e-6 / speed
        )
        line(away, 1e6 * shift, friction, label=f"{1e3 * speed:g} mm/s", **stroke(i, 3), lw=1.4)
    finish(away, "", "displacement [µm]\nbreaking away at constant speed")
    for i, pace in enumerate((1.0, 300.0, 1000.0)):
        time, _, rate, friction = _moved(
            lambda t: 0.0 * t,
            lambda t, w=pace: MIDDLE + SWING * np.sin(w * t),
            end=4.0 * np.pi / pace,
        )
        last = time >= 2.0 * np.pi / pace
        line(lag, 1e3 * rate[last], friction[last], label=f"{pace:g} rad/s", **stroke(i, 3), lw=1.4)
    finish(lag, "", "sliding speed [mm/s]\nsliding, speed going up and down")
    return figure


def _moved(shift, rate, end: float = 16.0 * np.pi):
    """Times, displacements, rates and friction over the normal force (n,) of bristles moved in a
    given way.
    """
    law = cl.lugre(**BRISTLES)
    time = np.linspace(0.0, end, 2001)
    solution = solve_ivp(
        lambda t, z: [law(float(z[0]), float(rate(t)), 1.0)[0]],
        (0.0, end),
        [0.0],
        "Radau",
        time,
        rtol=1e-7,
        atol=1e-13,
    )
    rates = np.broadcast_to(rate(time), time.shape)
    friction = [-law(float(z), float(v), 1.0)[1] for z, v in zip(solution.y[0], rates, strict=True)]
    return time, np.broadcast_to(shift(time), time.shape), rates, np.array(friction)
