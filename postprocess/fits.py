"""Pictures of identified joint friction: a fit beside what was measured.

Fits come from `clearance.identify.fit` (`fit`, or `open_fit` for a file), measurements from
`records.read`.
"""

import math
from pathlib import Path

import numpy as np
from clearance.postprocess import figures

from clearance.identify.fit import Fit, nrmse
from clearance.identify.records import LABELS, Measurement, Trial

#: axes of the housing, and how a joint moves about them
MOTIONS = ("tilt x", "tilt y", "spin")
COLUMNS, PANEL = 3, (3.7, 2.4)  # panels side by side, breadth and height of one [inch]
#: turning points shown of a history
TURNS = 6
MEASURED = {"color": "0.45", "lw": 1.3, "label": "measured"}
MODELLED = {"color": figures.STROKES[1]["color"], "lw": 0.9}
#: quantiles of the residuals of a class of speeds, and how many classes
BAND, CLASSES = (0.1, 0.5, 0.9), 24
#: rate [rad/s] below which speeds are one class
SLOWEST = 1e-3


def loops(fit: Fit, measurement: Measurement, path: str | Path) -> Path:
    """Torque over angle of every trial and measured axis, measured and modelled; saved under
    `path`.
    """

    def draw(axes, trial: Trial, axis: int, modelled: np.ndarray) -> None:
        angle = np.degrees(trial.angle[:, axis])
        figures.trajectory(axes, angle, trial.torque[:, axis], **MEASURED)
        figures.trajectory(axes, angle, modelled, **MODELLED, label=fit.model.name)

    return _page(fit, measurement, path, draw, "angle [°]")


def histories(fit: Fit, measurement: Measurement, path: str | Path) -> Path:
    """Torque over time of every trial and measured axis up to its sixth turning point; saved under
    `path`.
    """

    def draw(axes, trial: Trial, axis: int, modelled: np.ndarray) -> None:
        end = _end(trial.rate[:, axis])
        figures.line(axes, trial.time[:end], trial.torque[:end, axis], **MEASURED)
        figures.line(axes, trial.time[:end], modelled[:end], **MODELLED, label=fit.model.name)

    return _page(fit, measurement, path, draw, "time [s]")


def columns(fit: Fit, measurement: Measurement, units: dict[str, str], path: str | Path) -> Path:
    """Columns of every trial over time, measured and modelled, and their difference; saved under
    `path`.

    units: of the columns that the model predicts.
    """
    shown = [(t, c) for t in measurement.trials for c in units]
    figure = figures.sheet(2.6 * PANEL[0], PANEL[1] * len(shown) + 0.9)
    panels = figure.subplots(len(shown), 2, squeeze=False, sharex="row", width_ratios=(1.6, 1.0))
    modelled = {t.name: fit.model.modelled(fit.values, t) for t in measurement.trials}
    for (trial, column), (curves, right) in zip(shown, panels, strict=True):
        values = modelled[trial.name][column]
        figures.line(curves, trial.time, trial[column], **MEASURED)
        figures.line(curves, trial.time, values, **MODELLED, label=fit.model.name)
        figures.line(right, trial.time, values - trial[column], color="0.3", lw=0.7)
        curves.set_title(f"{trial.name}: {_error(trial[column], values)}", fontsize="small")
        right.set_title("modelled less measured", fontsize="small")
        figures.finish(curves, f"{column} [{units[column]}]", "", legend=False)
        figures.finish(right, f"[{units[column]}]", "", legend=False)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    figure.suptitle(f"{fit.model.name}: {', '.join(measurement.roles)}", fontsize="medium")
    figures.legend_below(figure, panels.flat[0])
    return figures.save(figure, path)


def _end(rate: np.ndarray) -> int:
    """Samples up to a turning point, or all."""
    moving = np.flatnonzero(rate)
    turned = moving[1:][np.diff(np.sign(rate[moving])) != 0.0]
    return int(turned[TURNS - 1]) if len(turned) >= TURNS else len(rate)


def _page(fit: Fit, measurement: Measurement, path: str | Path, draw, xlabel: str) -> Path:
    """A panel for each measured axis of each trial, filled by `draw`."""
    shown = [(t, i) for t in measurement.trials for i in range(3) if t.measured[i]]
    columns = min(COLUMNS, len(shown))
    rows = math.ceil(len(shown) / columns)
    figure = figures.sheet(PANEL[0] * columns, PANEL[1] * rows + 0.9)
    panels = figure.subplots(rows, columns, squeeze=False)
    torques = {t.name: fit.torque(t) for t in measurement.trials}
    for (trial, axis), axes in zip(shown, panels.flat, strict=False):
        modelled = torques[trial.name][:, axis]
        draw(axes, trial, axis, modelled)
        axes.set_title(
            f"{_title(trial, axis)}\n{_error(trial.torque[:, axis], modelled)}", fontsize="small"
        )
        figures.finish(axes, "", "", legend=False)
        axes.tick_params(labelsize="small")
    for axes in panels.flat[len(shown) :]:
        axes.set_visible(False)
    for k in range(columns):
        panels.flat[len(shown) - 1 - k].set_xlabel(xlabel)
    figure.supylabel("torque [N m]", fontsize="medium")
    figure.suptitle(_headline(fit, measurement), fontsize="medium")
    figures.legend_below(figure, panels.flat[0])
    return figures.save(figure, path)


def _title(trial: Trial, axis: int) -> str:
    """A trial in a few words: its name, and how it moves where that is known."""
    motion, facts = [MOTIONS[axis]], trial.facts
    if "amplitude" in facts:
        motion.append(f"{math.degrees(facts['amplitude']):.3g}°")
    if "speed" in facts:
        motion.append(f"{math.degrees(facts['speed']):.4g}°/s")
    if "frequency" in facts:
        motion.append(f"{facts['frequency']:.3g} Hz")
    return f"{trial.name}: {', '.join(motion)}"


def _error(measured: np.ndarray, modelled: np.ndarray) -> str:
    return f"NRMSE {nrmse(measured, modelled):.3f}" if measured.any() else "measured torque is zero"


def _headline(fit: Fit, measurement: Measurement) -> str:
    roles = ", ".join(measurement.roles)
    about = measurement.facts.get("title", "measured joint friction")
    return f"{about}: {fit.model.name}, {roles}, NRMSE {fit.score(measurement.trials):.3f}"


def residuals(fit: Fit, measurement: Measurement, path: str | Path) -> Path:
    """NRMSE of every trial; how residuals are distributed, and how they depend on the speed; saved
    under `path`.
    """
    trials = sorted(measurement.trials, key=lambda t: LABELS["role"].index(t.role))
    figure = figures.sheet(11.0, max(5.0, 0.2 * len(trials) + 1.2))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
    styles = {role: figures.stroke(i, len(LABELS["role"])) for i, role in enumerate(LABELS["role"])}
    _bars(figure.add_subplot(grid[:, 0]), fit, trials, styles)
    _shares(figure.add_subplot(grid[0, 1]), fit, measurement, styles)
    _speeds(figure.add_subplot(grid[1, 1]), fit, measurement)
    figure.suptitle(
        f"{measurement.facts.get('title', 'measured joint friction')}: residuals of "
        f"{fit.model.name}"
    )
    return figures.save(figure, path)


def _bars(axes, fit: Fit, trials: list[Trial], styles: dict[str, dict]) -> None:
    """NRMSE of trials, and of their roles as lines."""
    for role in dict.fromkeys(t.role for t in trials):
        places = [i for i, t in enumerate(trials) if t.role == role]
        colour = styles[role]["color"]
        axes.barh(
            places, [fit.score([trials[i]]) for i in places], color=colour, alpha=0.6, height=0.7
        )
        score = fit.score([trials[i] for i in places])
        ends = places[0] - 0.5, places[-1] + 0.5
        axes.vlines(score, *ends, color=colour, lw=1.8, label=f"{role} {score:.3f}")
    axes.set_yticks(range(len(trials)), [t.name for t in trials], fontsize="small")
    axes.set_ylim(len(trials) - 0.4, -0.6)
    axes.margins(x=0.02)
    figures.finish(axes, "", "NRMSE, rms error over rms torque [-]; line: role")
    axes.grid(axis="y", visible=False)


def _errors(fit: Fit, trials) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rate [rad/s] and residual [N m] of every measured axis of trials."""
    return [
        (t.rate[:, i], (fit.torque(t) - t.torque)[:, i])
        for t in trials
        for i in range(3)
        if t.measured[i]
    ]


def _shares(axes, fit: Fit, measurement: Measurement, styles: dict[str, dict]) -> None:
    """Densities of the residuals by role."""
    by_role = {
        r: np.concatenate([e for _, e in _errors(fit, measurement.of(r).trials)])
        for r in measurement.roles
    }
    widest = max(np.quantile(abs(e), 0.995) for e in by_role.values()) or 1.0
    for role, errors in by_role.items():
        heights, edges = np.histogram(errors, 120, (-widest, widest))
        density = heights / (len(errors) * (edges[1] - edges[0]))
        axes.stairs(
            density,
            edges,
            label=f"{role}, rms {np.sqrt(np.mean(errors**2)):.3f} N m",
            **styles[role],
        )
    figures.finish(axes, "density [1/(N m)]", "residual, modelled less measured torque [N m]")


def _speeds(axes, fit: Fit, measurement: Measurement) -> None:
    """Median and 10 to 90 % band of the residual over the speed, of the roles that were fitted and
    those that were not.

    Residuals count along the motion: positive where the model brakes too much.
    """
    roles = set(fit.facts.get("roles", ("training",)))
    parts = {
        "fitted": [t for t in measurement.trials if t.role in roles],
        "not fitted": [t for t in measurement.trials if t.role not in roles],
    }
    for i, (name, trials) in enumerate((n, t) for n, t in parts.items() if t):
        rate, error = map(np.concatenate, zip(*_errors(fit, trials), strict=True))
        speed, along = np.maximum(abs(rate), SLOWEST), error * np.sign(rate)
        edges = np.geomspace(SLOWEST, max(speed.max(), 2.0 * SLOWEST), CLASSES + 1)
        rank = np.clip(np.searchsorted(edges, speed, side="right") - 1, 0, CLASSES - 1)
        classes = [k for k in range(CLASSES) if np.count_nonzero(rank == k) >= 20]
        low, middle, high = (
            np.array([np.quantile(along[rank == k], BAND) for k in classes]).reshape(-1, 3).T
        )
        centres = np.degrees(np.sqrt(edges[:-1] * edges[1:])[classes])
        style = figures.stroke(i, 2)
        axes.fill_between(centres, low, high, color=style["color"], alpha=0.2, lw=0.0)
        axes.plot(centres, middle, **style, marker=".", label=f"{name}: median, 10 to 90 %")
    axes.axhline(0.0, color="0.4", lw=0.6)
    axes.set_xscale("log")
    figures.finish(axes, "residual along the motion [N m]", "speed about the axis [°/s]")


def progress(fit: Fit, path: str | Path) -> Path:
    """Cost over the iterations from the best start, and the cost that each start reached; saved
    under `path`.
    """
    starts = np.asarray(fit.starts.get("cost", ()))
    figure = figures.sheet(9.0 if len(starts) > 1 else 5.5, 3.4)
    panels = np.atleast_1d(figure.subplots(1, 2 if len(starts) > 1 else 1))
    history = np.asarray(fit.history)
    if len(history) > 1:
        panels[0].plot(
            np.arange(len(history)),
            history,
            marker="." if len(history) < 60 else "",
            **figures.stroke(0, 1),
        )
        panels[0].set_yscale("log")
        figures.finish(
            panels[0], "cost, half the sum of squares [(N m)²]", "iteration", legend=False
        )
        panels[0].set_title("from the best start", fontsize="medium")
    else:
        figures.note(panels[0], "no iterations:\nlinear least squares")
    if len(starts) > 1:
        order = np.sort(starts)
        panels[1].plot(
            np.arange(1, len(order) + 1), order / order[0], "o", color=figures.STROKES[0]["color"]
        )
        panels[1].set_xticks(np.arange(1, len(order) + 1))
        panels[1].margins(y=0.15)
        figures.finish(panels[1], "cost over the least [-]", "start, by its cost", legend=False)
        panels[1].set_title("all starts, before the best is finished", fontsize="medium")
    figure.suptitle(f"{fit.model.name}: estimation in {fit.facts.get('seconds', math.nan):.3g} s")
    return figures.save(figure, path)
