"""Mobile manipulator: inputs, pins, actuators and tooth, and the start-up of its input filter.

Group: manipulator

Answers: Chacko and Khan, Tribology in Industry 39 (2017), simulations 1 to 3. Inputs with both
derivatives (Figs. 8 to 11 of the source). Angle, speed, acceleration, torque and friction torque of
the pins J1 to J3 (Figs. 13 to 15). Force and friction force of the actuators (Figs. 16 to 18), with
the combined breakaway, Coulomb and viscous friction in all pins and slides. Path of the tooth with
the effect of the filter (Fig. 20). A pin is passive: the torque shown is that of its actuator about
it, force times lever arm. Axes leave out the filter's start-up, which has its own picture.

Reproduced: printed masses, centres of mass, sinusoids, time constants of the input filter and
friction levels, with the linear zone at rest. The start-up transient of the filter: its
acceleration starts with a jump and turns round, with its extremum at twice the time constant.

Assumed: every length, anchor and inertia, the direction of the load of 150 N, and the match of
sinusoids and actuators. Also the dig pattern of simulations 2 and 3, which the source shows as a
figure only.

Not comparable: forces and strokes. The printed +-1 N of actuator force cannot go with loads of 150
N. The printed 27.6 N m of pin torque is more than the printed friction law can give. Of the printed
peak times 0.1995 s is twice the filter's time constant, 0.103 s close to it and 0.181 s
between: they are read as its start-up, which the missing lengths leave unproved.
"""

import numpy as np
from clearance.cases.mobile_manipulator import (
    ACTUATORS,
    DIGS,
    LINKS,
    PHASES,
    SWINGS,
    TIME_CONSTANTS,
    dug,
    swung,
)
from clearance.paper_figures import workshop
from clearance.postprocess.drawing import sketch
from clearance.postprocess.figures import finish, legend_below, line, sheet, stroke

UNTIL, STEP = 40.0, 0.01  # s
STARTED = 1.0  # s, after which the filter's start-up is over
PRINTED = (0.103, 0.181, 0.1995)  # s, when the source's pin torques peak
#: bias and amplitude [m], frequency [rad/s] of the source's general input
FIGURE_8 = (0.020, 0.025, 1.0)
PINS = {"J1": (None, "boom"), "J2": ("boom", "stick"), "J3": ("stick", "bucket")}
FRICTION = {"breakaway": "source's friction", "coulomb": "friction made by the loads"}


def draw(work: workshop.Workshop) -> None:
    samples = round(UNTIL / work.less(STEP, 0.04)) + 1
    runs = {
        (n, law): work.inverse(
            "mobile_manipulator", {"simulation": n, "friction": law}, until=UNTIL, samples=samples
        )
        for n in TIME_CONSTANTS
        for law in FRICTION
    }
    work.drawing(sketch, runs[2, "breakaway"])
    rubbing = {n: runs[n, "breakaway"] for n in TIME_CONSTANTS}
    work.keep(inputs(rubbing[1].time), "inputs")
    work.keep(pins(rubbing), "pins")
    work.keep(forces(rubbing), "forces")
    work.keep(slides(rubbing), "slides")
    work.keep(paths(rubbing), "path")
    fast = {
        tau: work.inverse(
            "mobile_manipulator", {"time_constant": tau}, until=6.0 * tau, samples=601
        )
        for tau in (0.1, 0.01)
    }
    work.keep(startup(fast), "startup")
    peaks(work, runs)


def path_of(run, body: str, x: float, y: float) -> np.ndarray:
    """Path (samples, 2) of a point of a body, given in its frame [m]."""
    com = next(b["com"] for b in run.scene["bodies"] if b["name"] == body)
    body_channels = run[body]
    arm = ((x - com[0]) + 1j * (y - com[1])) * np.exp(1j * body_channels.theta)
    return np.column_stack([body_channels.x + arm.real, body_channels.y + arm.imag])


def stroke_of(run, name: str) -> np.ndarray:
    """Extension of an actuator (samples,) [m]: distance of its pins beyond that at zero."""
    apart = path_of(run, f"{name}_rod", 0.0, 0.0) - path_of(run, f"{name}_barrel", 0.0, 0.0)
    return np.hypot(*apart.T) - ACTUATORS[name].length


def moved(time: np.ndarray, name: str, simulation: int) -> np.ndarray:
    """An input with its two derivatives (3, samples) [m, m/s, m/s2]; simulation 0: that of Fig. 8.

    The second derivative is that of the filter's equation T^2 y'' + 2 T y' + y = u.
    """
    if simulation == 0:
        bias, amplitude, frequency = FIGURE_8
        swing = amplitude * np.sin(frequency * time)
        rate = amplitude * frequency * np.cos(frequency * time)
        return np.array([bias + swing, rate, -(frequency**2) * swing])
    tau = TIME_CONSTANTS[simulation]
    if simulation == 1:
        signal = np.array([swung(t, *SWINGS[name], 0.0)[0] for t in time])
        behind = [swung(t, *SWINGS[name], tau) for t in time]
    else:
        signal = np.interp(time, (0.0, *PHASES), (0.0, *DIGS[name]))
        behind = [dug(t, *DIGS[name], tau) for t in time]
    position, rate = np.array(behind).T
    return np.array([position, rate, (signal - position - 2.0 * tau * rate) / tau**2])


def curves(axes, time: np.ndarray, values: dict) -> None:
    """Named curves [(samples,)], the axis as high as they are after the filter's start-up."""
    for i, (name, curve) in enumerate(values.items()):
        line(axes, time, curve, label=name, **stroke(i, 3), lw=(2.2, 1.4, 1.2)[i])
    late = np.array(list(values.values()))[:, time >= STARTED]
    room = 0.08 * (late.max() - late.min())
    axes.set_ylim(late.min() - room, late.max() + room)


def grid(panels, labels, heads) -> None:
    """Heads above the columns, labels beside the rows, the time below."""
    for axes in panels.flat:
        finish(axes, "", "", legend=False)
    for axes, head in zip(panels[0], heads, strict=True):
        axes.set_title(head, fontsize="medium")
    for axes, label in zip(panels[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    panels[0, 0].figure.align_ylabels()
    legend_below(panels[0, 0].figure, panels[0, -1])


HEADS = [f"simulation {n}, filter {tau:g} s" for n, tau in TIME_CONSTANTS.items()]


def inputs(time: np.ndarray):
    """Inputs with both derivatives: the source's general sine, and simulations 1 to 3."""
    figure = sheet(11.0, 7.0)
    panels = figure.subplots(3, 4, sharex="col")
    for n, column in enumerate(panels.T):
        shown = time if n else time[time <= 15.0]
        names = ACTUATORS if n else ("any actuator",)
        asked = {name: 1e3 * moved(shown, name, n) for name in names}
        for k, axes in enumerate(column):
            curves(axes, shown, {name: values[k] for name, values in asked.items()})
    labels = ("stroke [mm]", "its rate [mm/s]", "its acceleration [mm/s²]")
    grid(panels, labels, ["Fig. 8: 1 rad/s, no filter", *HEADS])
    return figure


def lever(run, pin: str) -> np.ndarray:
    """Lever arm of the actuator about a pin (samples,) [m]: its extension a turn of the pin."""
    before, name = PINS[pin]
    place_before = (0.0, 0.0) if before is None else LINKS[before][1]
    hinge = path_of(run, before, *place_before) if before else np.zeros((run.time.size, 2))
    base, end = path_of(run, f"{name}_barrel", 0.0, 0.0), path_of(run, f"{name}_rod", 0.0, 0.0)
    arm, along = end - hinge, (end - base) / np.hypot(*(end - base).T)[:, None]
    return arm[:, 0] * along[:, 1] - arm[:, 1] * along[:, 0]


def turned(run, pin: str, channel: str) -> np.ndarray:
    """A channel of the body that a pin moves, less that of the body before."""
    before, name = PINS[pin]
    return getattr(run[name], channel) - (getattr(run[before], channel) if before else 0.0)


def pins(runs: dict):
    """Motion of the pins J1 to J3, the actuators' torque about them, and their friction."""
    figure = sheet(11.0, 10.0)
    panels = figure.subplots(5, len(runs), sharex=True)
    for column, run in zip(panels.T, runs.values(), strict=True):
        parts = [
            {pin: np.degrees(turned(run, pin, channel)) for pin in PINS}
            for channel in ("theta", "omega", "alpha")
        ]
        parts += [
            {pin: run.drive(name).force * lever(run, pin) for pin, (_, name) in PINS.items()},
            {pin: run.joint(pin).friction for pin in PINS},
        ]
        for axes, values in zip(column, parts, strict=True):
            curves(axes, run.time, values)
    labels = (
        "angle [deg]",
        "speed [deg/s]",
        "acceleration\n[deg/s²]",
        "torque of the\nactuator [N m]",
        "friction torque\n[N m]",
    )
    grid(panels, labels, HEADS)
    return figure


def slides(runs: dict):
    """Force of the actuators and the part of it that their slides' friction takes."""
    figure = sheet(11.0, 5.5)
    panels = figure.subplots(2, len(runs), sharex=True)
    for column, run in zip(panels.T, runs.values(), strict=True):
        curves(column[0], run.time, {name: run.drive(name).force for name in ACTUATORS})
        rubs = {name: run.joint(f"{name}_slide").friction for name in ACTUATORS}
        curves(column[1], run.time, rubs)
    grid(panels, ("force [N]", "friction force\nof the slide [N]"), HEADS)
    return figure


def forces(runs: dict):
    """Strokes and actuator forces of the three simulations, a column each."""
    figure = sheet(11.0, 8.0)
    panels = figure.subplots(4, len(runs), sharex=True, sharey="row")
    for column, (n, run) in zip(panels.T, runs.items(), strict=True):
        for i, name in enumerate(ACTUATORS):
            line(
                column[0], run.time, 1e3 * stroke_of(run, name), label=name, **stroke(i, 3), lw=1.3
            )
            drive = run.drive(name)
            line(
                column[1 + i], run.time, drive.force, label="with friction", **stroke(1, 2), lw=0.9
            )
            line(
                column[1 + i], run.time, drive.force_ideal, label="without", **stroke(0, 2), lw=1.3
            )
        column[0].set_title(f"simulation {n}, filter {TIME_CONSTANTS[n]:g} s", fontsize="medium")
        for axes in column:
            finish(axes, "", "", legend=False)
        column[-1].set_xlabel("time [s]")
    panels[0, 0].set_ylabel("stroke [mm]")
    for axes, name in zip(panels[1:, 0], ACTUATORS, strict=True):
        axes.set_ylabel(f"force of {name} [N]")
    figure.align_ylabels()
    panels[0, 0].set_ylim(top=57.0)  # room for the legend
    panels[0, -1].legend(fontsize="small", ncols=3, loc="upper right", frameon=False)
    legend_below(figure, panels[1, 0])
    return figure


def off(path: np.ndarray, other: np.ndarray, most: int) -> np.ndarray:
    """Distance (samples,) of a path from another one, up to `most` samples sooner or later."""
    at = np.arange(len(path))
    least = np.full(len(path), np.inf)
    for k in range(-most, most + 1):
        i = np.clip(at + k, 0, len(other) - 2)
        begin, side = other[i], other[i + 1] - other[i]
        square = np.maximum((side**2).sum(axis=1), 1e-30)
        share = np.clip(((path - begin) * side).sum(axis=1) / square, 0.0, 1.0)
        least = np.minimum(least, np.hypot(*(path - begin - share[:, None] * side).T))
    return least


def paths(runs: dict):
    """Path of the tooth in the three simulations, and the slow filter's effect on the dig
    pattern.
    """
    figure = sheet(10.0, 5.5)
    cells = figure.add_gridspec(2, 2, width_ratios=(5, 4))
    axes, late, cut = (figure.add_subplot(c) for c in (cells[:, 0], cells[0, 1], cells[1, 1]))
    tooth = {n: 1e3 * path_of(run, "bucket", *LINKS["bucket"][1]) for n, run in runs.items()}
    time = runs[2].time
    beside = off(tooth[2], tooth[3], round(1.0 / (time[1] - time[0])))
    corner = tooth[2][beside.argmax()]
    near = axes.inset_axes((0.03, 0.03, 0.4, 0.4), xticks=[], yticks=[])
    for i, (n, path) in enumerate(tooth.items()):
        shown, style = path[time >= (STARTED if n == 1 else 0.0)], stroke(i, 3)
        axes.plot(*shown.T, label=f"simulation {n}", **style, lw=(1.2, 2.4, 1.0)[i])
        axes.plot(*shown[0], "o", ms=4, color=style["color"])
        near.plot(*path.T, **style, lw=1.4)
    size = 3.0 * beside.max()
    (low_x, low_y), (high_x, high_y) = corner - size, corner + size
    near.set(xlim=(low_x, high_x), ylim=(low_y, high_y), aspect="equal")
    axes.indicate_inset_zoom(near, edgecolor="0.3")
    near.set_title(f"{2.0 * size:.2g} mm wide", fontsize="small")
    axes.set_aspect("equal")
    finish(
        axes,
        "y of the tooth [mm]",
        f"x of the tooth [mm]; dot: begin, of simulation 1 after {STARTED:g} s",
    )
    line(late, time, np.hypot(*(tooth[2] - tooth[3]).T), **stroke(1, 3), lw=1.2)
    line(cut, time, beside, **stroke(1, 3), lw=1.2)
    finish(late, "simulation 2 from 3,\nat the same time [mm]", "", legend=False)
    finish(cut, "simulation 2 from\nthe path of 3 [mm]", legend=False)
    late.set_title("filter 0.1 s against 0.01 s: lag, and corners cut", fontsize="medium")
    return figure


def startup(runs: dict):
    """Simulation 1 behind a slow and a fast filter: stroke, its rates and the force without
    friction.
    """
    figure = sheet(9.0, 8.5)
    panels = figure.subplots(4, len(runs), sharex="col")
    labels = ("stroke [mm]", "its rate [mm/s]", "its acceleration [m/s²]", "force, no friction [N]")
    for column, (tau, run) in zip(panels.T, runs.items(), strict=True):
        for i, name in enumerate(ACTUATORS):
            asked = np.array([swung(t, *SWINGS[name], tau) for t in run.time])
            acceleration = np.gradient(asked[:, 1], run.time, edge_order=2)
            shown = (
                1e3 * asked[:, 0],
                1e3 * asked[:, 1],
                acceleration,
                run.drive(name).force_ideal,
            )
            for axes, values in zip(column, shown, strict=True):
                line(axes, run.time, values, label=name, **stroke(i, 3), lw=(2.8, 1.2, 1.2)[i])
        for axes, label in zip(column, labels, strict=True):
            for moment in (tau, 2.0 * tau):
                axes.axvline(moment, color="0.4", lw=0.8, ls=":")
            finish(axes, label, "", legend=False)
        column[0].set_title(f"filter {tau:g} s (dotted: once and twice that)", fontsize="medium")
        column[-1].set_xlabel("time [s]")
    acceleration = panels[2, 0]
    bottom = acceleration.get_xaxis_transform()
    acceleration.plot(
        PRINTED,
        [0.06] * 3,
        "^",
        ms=6,
        color="0.2",
        mfc="none",
        transform=bottom,
        label="peaks of pin torque, as printed",
    )
    figure.align_ylabels()
    legend_below(figure, panels[0, 0], acceleration)
    return figure


def peaks(work: workshop.Workshop, runs: dict) -> None:
    """Least and largest actuator forces after the start-up."""
    heads = ["simulation", "actuator", "least, no friction [N]", "largest [N]"]
    heads += [
        f"{which}, {text} [N]" for text in FRICTION.values() for which in ("least", "largest")
    ]
    rows = []
    for n in TIME_CONSTANTS:
        for name in ACTUATORS:
            drives = [runs[n, law].drive(name) for law in FRICTION]
            late = runs[n, "breakaway"].time > STARTED
            curves = [drives[0].force_ideal[late], *(d.force[late] for d in drives)]
            rows.append(
                [
                    str(n),
                    name,
                    *(float(v) for values in curves for v in (values.min(), values.max())),
                ]
            )
    remarks = (
        "After the first second. The source's friction, 20 to 25 N m in every pin, outweighs its "
        "loads of 150 N; "
        "beside it Coulomb friction made by the reactions, with coefficient 0.1 and pins of 10 mm "
        "radius (assumed)."
    )
    work.table(heads, rows, remarks=remarks)
