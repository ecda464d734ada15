"""Mobile manipulator: actuator forces with and without joint friction, and the start-up of its input filter.

Group: manipulator

Answers: Chacko and Khan, Tribology in Industry 39 (2017), simulations 1 to 3: strokes and forces of the actuators with
the combined breakaway, Coulomb and viscous friction in all pins and slides, and the path of the bucket.

Reproduced: printed masses, centres of mass, sinusoids, time constants of the input filter and friction levels, with the
linear zone at rest; the start-up transient of the filter, whose acceleration starts with a jump and turns round, with
its extremum at twice the time constant.

Assumed: every length, anchor and inertia, the direction of the load of 150 N, which sinusoid moves which actuator, and
the dig pattern of simulations 2 and 3, which the source shows as a figure only.

Not comparable: forces and strokes. The printed +-1 N of actuator force cannot go with loads of 150 N, and the printed
27.6 N m of pin torque is more than the printed friction law can give. Of the printed peak times 0.1995 s is twice the
filter's time constant, 0.103 s close to it and 0.181 s between: they are read as its start-up, which the missing
lengths leave unproved.
"""

import numpy as np
from clearance.cases.mobile_manipulator import ACTUATORS, LINKS, SWINGS, TIME_CONSTANTS, swung
from clearance.paper_figures import workshop
from clearance.postprocess.drawing import sketch
from clearance.postprocess.figures import finish, legend_below, line, sheet, stroke

UNTIL, STEP = 40.0, 0.01  # s
STARTED = 1.0  # s, after which the filter's start-up is over
PRINTED = (0.103, 0.181, 0.1995)  # s, when the source's pin torques peak
FRICTION = {"breakaway": "source's friction", "coulomb": "friction made by the loads"}


def draw(work: workshop.Workshop) -> None:
    samples = round(UNTIL / work.less(STEP, 0.04)) + 1
    runs = {
        (n, law): work.inverse("mobile_manipulator", {"simulation": n, "friction": law}, until=UNTIL, samples=samples)
        for n in TIME_CONSTANTS
        for law in FRICTION
    }
    work.drawing(sketch, runs[2, "breakaway"])
    work.keep(forces({n: runs[n, "breakaway"] for n in TIME_CONSTANTS}), "forces")
    work.keep(paths({n: runs[n, "breakaway"] for n in TIME_CONSTANTS}), "path")
    fast = {
        tau: work.inverse("mobile_manipulator", {"time_constant": tau}, until=6.0 * tau, samples=601)
        for tau in (0.1, 0.01)
    }
    work.keep(startup(fast), "startup")
    peaks(work, runs)


def place(run, body: str, x: float, y: float) -> np.ndarray:
    """Path (samples, 2) of a point of a body, given in its frame [m]."""
    com = next(b["com"] for b in run.scene["bodies"] if b["name"] == body)
    own = run[body]
    arm = ((x - com[0]) + 1j * (y - com[1])) * np.exp(1j * own.theta)
    return np.column_stack([own.x + arm.real, own.y + arm.imag])


def stroke_of(run, name: str) -> np.ndarray:
    """Extension of an actuator (samples,) [m]: distance of its pins beyond that at zero."""
    apart = place(run, f"{name}_rod", 0.0, 0.0) - place(run, f"{name}_barrel", 0.0, 0.0)
    return np.hypot(*apart.T) - ACTUATORS[name].length


def forces(runs: dict):
    """Strokes and actuator forces of the three simulations, a column each."""
    figure = sheet(11.0, 8.0)
    panels = figure.subplots(4, len(runs), sharex=True, sharey="row")
    for column, (n, run) in zip(panels.T, runs.items(), strict=True):
        for i, name in enumerate(ACTUATORS):
            line(column[0], run.time, 1e3 * stroke_of(run, name), label=name, **stroke(i, 3), lw=1.3)
            drive = run.drive(name)
            line(column[1 + i], run.time, drive.force, label="with friction", **stroke(1, 2), lw=0.9)
            line(column[1 + i], run.time, drive.force_ideal, label="without", **stroke(0, 2), lw=1.3)
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


def paths(runs: dict):
    """Path of the tooth in the three simulations."""
    figure = sheet(6.0, 5.0)
    axes = figure.add_subplot()
    for i, (n, run) in enumerate(runs.items()):
        path = 1e3 * place(run, "bucket", *LINKS["bucket"][1])[run.time >= (STARTED if n == 1 else 0.0)]
        axes.plot(*path.T, label=f"simulation {n}", **stroke(i, 3), lw=(1.2, 2.4, 1.0)[i])
        axes.plot(*path[0], "o", ms=4, color=stroke(i, 3)["color"])
    axes.set_aspect("equal")
    finish(axes, "y of the tooth [mm]", f"x of the tooth [mm]; dot: begin, of simulation 1 after {STARTED:g} s")
    return figure


def startup(runs: dict):
    """Simulation 1 behind a slow and a fast filter: stroke, its rates and the force without friction."""
    figure = sheet(9.0, 8.5)
    panels = figure.subplots(4, len(runs), sharex="col")
    labels = ("stroke [mm]", "its rate [mm/s]", "its acceleration [m/s²]", "force, no friction [N]")
    for column, (tau, run) in zip(panels.T, runs.items(), strict=True):
        for i, name in enumerate(ACTUATORS):
            asked = np.array([swung(t, *SWINGS[name], tau) for t in run.time])
            acceleration = np.gradient(asked[:, 1], run.time, edge_order=2)
            shown = (1e3 * asked[:, 0], 1e3 * asked[:, 1], acceleration, run.drive(name).force_ideal)
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
    acceleration.plot(PRINTED, [0.06] * 3, "^", ms=6, color="0.2", mfc="none", transform=bottom,
                      label="peaks of pin torque, as printed")  # fmt: skip
    figure.align_ylabels()
    legend_below(figure, panels[0, 0], acceleration)
    return figure


def peaks(work: workshop.Workshop, runs: dict) -> None:
    """Least and largest actuator forces after the start-up."""
    heads = ["simulation", "actuator", "least, no friction [N]", "largest [N]"]
    heads += [f"{which}, {text} [N]" for text in FRICTION.values() for which in ("least", "largest")]
    rows = []
    for n in TIME_CONSTANTS:
        for name in ACTUATORS:
            drives = [runs[n, law].drive(name) for law in FRICTION]
            late = runs[n, "breakaway"].time > STARTED
            found = [drives[0].force_ideal[late], *(d.force[late] for d in drives)]
            rows.append([str(n), name, *(float(v) for values in found for v in (values.min(), values.max()))])
    remarks = (
        "After the first second. The source's friction, 20 to 25 N m in every pin, outweighs its loads of 150 N; "
        "beside it Coulomb friction made by the reactions, with coefficient 0.1 and pins of 10 mm radius (assumed)."
    )
    work.table(heads, rows, remarks=remarks)


if __name__ == "__main__":
    workshop.main(__file__)
