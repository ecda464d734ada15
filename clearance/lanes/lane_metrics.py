"""Metrics of points in lanes: what of a run is looked at, and what comes of it.

One point is run the ordinary way; it gives the metrics, their units and texts. Those of
all others are made from what lanes keep: extremes in each turn, sums and tracks of samples. Other
metrics, and runs that do not end with a complete turn, are `NotForLanes`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from clearance.accuracy.companion import SAFETY, differences, spreads
from clearance.accuracy.point_errors import Stating, is_period
from clearance.elements.regimes import FLATTENING, FULL_FILM, PIEZOVISCOUS, regime
from clearance.lanes.group import Answers, Points
from clearance.lanes.point_numbers import NotForLanes
from clearance.lanes.watch import Quantity, Reduction, Watch
from clearance.metrics.metrics import ROUNDING, Metric, Window, periodicity
from clearance.metrics.of_points import of_point
from clearance.results.extremes import along, guides
from clearance.results.memory import Memory, MemoryRecord
from clearance.run.diagnosis import doubtful
from clearance.run.ideal_motion import ideal_motion
from clearance.run.run import Run
from clearance.stepping import status


@dataclass
class Wanted:
    """Quantities and reductions that metrics look at, with the outputs that they are made of, by
    name.
    """

    layout: object
    channels: list[int] = field(default_factory=list)
    quantities: dict[str, Quantity] = field(default_factory=dict)
    reductions: dict[str, Reduction] = field(default_factory=dict)
    tracks: dict[str, int] = field(default_factory=dict)

    def channel(self, path: str, count: int = 1) -> int:
        """Place of an output among those looked at; count: of outputs that follow each other."""
        return self.place(self.layout.output[path], count)

    def place(self, first: int, count: int = 1) -> int:
        """As `channel`, from the place among all outputs."""
        for i in range(len(self.channels) - count + 1):
            if self.channels[i : i + count] == list(range(first, first + count)):
                return i
        self.channels += range(first, first + count)
        return len(self.channels) - count

    def located(self, path: str, end: str, **options) -> None:
        """An extreme of an output."""
        sign = -1.0 if end == "min" else 1.0
        self.quantities[f"{path}_{end}"] = Quantity(self.channel(path), False, sign, **options)

    def force(self, joint: str) -> None:
        """Largest and mean square force of a joint."""
        c = self.channel(f"joints/{joint}/force_x", 2)
        self.quantities[f"joints/{joint}/force_max"] = Quantity(c, True, 1.0)
        self.mean(
            f"{joint} force",
            lambda p, row, ideal, constants: row[c] * row[c] + row[c + 1] * row[c + 1],
        )

    def mean(self, name: str, value: Callable) -> None:
        """Mean over the steps."""
        self.reductions[name] = Reduction(value, stepped=True)

    def square(self, name: str, path: str) -> None:
        """Mean square of an output."""
        c = self.channel(path)
        self.mean(name, lambda p, row, ideal, constants: row[c] * row[c])

    def watch(self, given: int, extra: int) -> Watch:
        return Watch(
            tuple(self.quantities.values()),
            tuple(self.reductions.values()),
            tuple(self.tracks.values()),
            given,
            extra,
        )


class LaneMetrics:
    """Outputs that are looked at in runs of one structure, and metrics made of them.

    run: of one point, not begun: it is run here; settle: turns left out of the metrics; error: that
    is to be stated, as of `simulate`.
    first: its metrics; stated: their errors. Raises NotForLanes.
    """

    def __init__(self, run: Run, settle: float | None, error: float | str | dict | None = None):
        stating = Stating(run, error, settle)
        if stating.request is not None:
            raise NotForLanes("a requested error chooses the tolerance of each point")
        self.mechanism, self.solver, self.span, self.settle = (
            run.mechanism,
            run.solver,
            run.span,
            settle,
        )
        sink = Memory(run.mechanism.layout.channels, run.attributes())
        if failure := run.record(sink):
            raise NotForLanes(f"its first point fails: {failure}")
        self.record: MemoryRecord = sink.record
        self.ideal = ideal_motion(run.mechanism.scene, run.span, self.record.scene)
        self.first = of_point(self.record, self.settle, self.ideal)
        self.steps = int(self.record.solver["steps"])
        self._check_window()
        self._want()
        self.stated, self.located = self._state(stating), []
        if self.stated:
            self._want_located(run)

    @property
    def given(self) -> np.ndarray:
        """Ideal motions at each sample, which reductions are given: (numbers, samples)."""
        rows = [row for pair in (self.ideal or {}).values() for row in pair]
        return np.array(rows).reshape(len(rows), self.span.samples)

    @property
    def watch(self) -> Watch:
        """Outputs that lanes keep of each run."""
        return self.wanted.watch(2 * len(self.ideal or {}), 1)

    @property
    def kept(self) -> int:
        """Numbers that are stored of a run."""
        turns = math.ceil(self.span.until / self.mechanism.scene.turn)
        return len(self.wanted.tracks) * self.span.samples + len(self.wanted.quantities) * turns

    def _check_window(self) -> None:
        """Metrics are about the last complete turns of the run, which begin with a turn."""
        window = Window.of(self.record, self.settle)
        turn, until = self.mechanism.scene.turn, self.span.until
        if window is None or not turn or window.turns is None or self.record.uneven:
            raise NotForLanes("no drive turns at a constant speed")
        before = window.begin / turn
        self.past = round(before)  # turns before the window
        on_turn = abs(before - self.past) < ROUNDING
        if not on_turn or window.end < until * (1.0 - ROUNDING) or window.turns < 1.0 - ROUNDING:
            raise NotForLanes("the run does not end with the whole turns of its metrics")
        self.window, self.turns = window, window.turns

    def _state(self, stating: Stating) -> dict[str, Metric]:
        """Stated errors of the first point. Raises NotForLanes where there are none."""
        summed = partial(of_point, settle=self.settle, ideal=self.ideal)
        stated = stating.columns(self.record, self.first, summed)
        if stating.left_out:
            raise NotForLanes(f"no stated errors: {stating.left_out}")
        return stated

    # --- outputs that are looked at
    def _want_located(self, run: Run) -> None:
        """The extremes that stated errors compare, beside those of metrics."""
        for q in run.watched.quantities:
            if q.name not in self.wanted.quantities:
                channel = self.wanted.place(q.channel, 1 + q.paired)
                self.wanted.quantities[q.name] = Quantity(channel, q.paired, q.sign)
            self.located.append(q.name)

    def _want(self) -> None:
        self.wanted = wanted = Wanted(self.mechanism.layout)
        output = self.mechanism.layout.output
        joints = [j for j in self.mechanism.scene.joints if f"joints/{j.name}/force_x" in output]
        for joint in joints:
            wanted.force(joint.name)
        for joint in self.mechanism.scene.clearance_joints:
            if joint.contact is not None:
                self._want_contact(joint)
            wanted.located(f"joints/{joint.name}/gap", "min", always=True)
            if f"joints/{joint.name}/film_pressure" in output:
                wanted.located(f"joints/{joint.name}/film_pressure", "max", always=True)
        for path in output:
            kind, _, name = path.partition("/")[0], *path.rpartition("/")[1:]
            if kind == "drives" and name in ("torque", "force"):
                wanted.located(path, "min")
                wanted.located(path, "max")
                wanted.square(path, path)
        self._want_slides()
        for end in ("min", "max"):
            for path in ("energy/kinetic", "energy/residual"):
                if path in output:
                    wanted.located(path, end, always=True, searched=False)
        if self.turns >= 3.0:
            for joint in self.mechanism.scene.clearance_joints:
                for name in ("eccentricity_x", "eccentricity_y"):
                    if (path := f"joints/{joint.name}/{name}") in output:
                        wanted.tracks[path] = wanted.channel(path)

    def _want_contact(self, joint) -> None:
        """Share of the time in contact of a joint whose contact sets in gradually."""
        if (path := f"joints/{joint.name}/contact_force") not in self.mechanism.layout.output:
            raise NotForLanes(f"joint {joint.name} touches at several places")
        c = self.wanted.channel(path)
        self.wanted.mean(
            f"{joint.name} contact", lambda p, row, ideal, constants: p.flag(p.above(row[c], 0.0))
        )

    def _want_slides(self) -> None:
        """Motion of bodies along guides, and how far it is from that with ideal joints."""
        wanted = self.wanted
        for number, (body, (dx, dy)) in enumerate(guides(self.record.scene).items()):
            path = f"bodies/{body}/a{along((dx, dy))[0]}"
            wanted.located(path, "min")
            wanted.located(path, "max")
            if body not in (self.ideal or {}):
                continue
            x, y, ax, ay = (wanted.channel(f"bodies/{body}/{n}") for n in ("x", "y", "ax", "ay"))

            def far(p, row, ideal, constants, x=x, y=y, dx=dx, dy=dy, k=2 * number):
                return p.size(row[x] * dx + row[y] * dy - ideal[k])

            def beyond(p, row, ideal, constants, ax=ax, ay=ay, dx=dx, dy=dy, k=2 * number + 1):
                gap = row[ax] * dx + row[ay] * dy - ideal[k] * constants[0]
                return gap * gap

            wanted.reductions[f"{body} far"] = Reduction(far, mean=False)
            wanted.reductions[f"{body} beyond"] = Reduction(beyond)

    # --- metrics
    def sound(self, answers: Answers, points: Points) -> np.ndarray:
        """True for runs that reached their end, whose energy adds up, and whose surfaces stay away
        from contact.
        """
        good = (answers.status == status.DONE) & ~self._near(answers, points)
        if "energy/residual_max" not in self.wanted.quantities:
            return good
        ends = {
            n: self._of_all(answers, f"energy/{n}", self.past)
            for n in ("kinetic_max", "kinetic_min")
        }
        ends |= {
            n: self._of_all(answers, f"energy/{n}", self.past)
            for n in ("residual_max", "residual_min")
        }
        turned = np.maximum(ends["kinetic_max"] - ends["kinetic_min"], 1e-300)
        doubt = doubtful(self.solver.rtol)
        return good & (ends["residual_max"] - ends["residual_min"] <= doubt * turned)

    def _of_all(self, answers: Answers, name: str, first: int = 0) -> np.ndarray:
        """Outermost of the extremes of a quantity in the turns from one on."""
        values = answers.extremes[:, first:, list(self.wanted.quantities).index(name)]
        return values.min(axis=1) if name.endswith("_min") else values.max(axis=1)

    def metrics(self, answers: Answers, points: Points) -> dict[str, np.ndarray]:
        """Metrics of the points by name, as the first point has them.

        Raises NotForLanes for others.
        """
        by_name = {name: values for part in self._parts(answers, points) for name, values in part}
        if missing := [name for name in self.first if name not in by_name]:
            raise NotForLanes(f"metric {missing[0]} is not made in lanes")
        return {name: by_name[name] for name in self.first}

    def errors(
        self, answers: tuple[Answers, Answers, Answers], points: Points, times: float | np.ndarray
    ) -> dict[str, np.ndarray]:
        """Stated errors of the metrics, those of the first point; not a number where one cannot be
        stated.

        answers: of the points, of their companions, and of those with films that are stronger by so
        many times the errors of their tables.
        """
        parts = [self.metrics(answer, points) | self._located(answer) for answer in answers]
        numbers = {name: np.stack([part[name] for part in parts]) for name in parts[0]}
        by, stated = differences(numbers, spreads(numbers), times), {}
        for name in self.first:
            if f"{name}_error" in self.stated:
                integration, film = by[name]
                stated[f"{name}_error"] = SAFETY * integration + film
        return stated

    def stated_alike(self, values: dict, stated: dict) -> np.ndarray:
        """True for points whose metrics have errors where those of the first have."""
        good = [np.isfinite(errors) for errors in stated.values()]
        without = [n for n in self.first if f"{n}_error" not in stated and not is_period(n)]
        return np.logical_and.reduce([*good, *(~np.isfinite(values[n]) for n in without)])

    def _located(self, answers: Answers) -> dict[str, np.ndarray]:
        """Located extremes of the window that stated errors compare."""
        return {name: self._of_all(answers, name, self.past) for name in self.located}

    def _parts(self, answers: Answers, points: Points):
        by_turn = np.moveaxis(answers.extremes[:, self.past :], -1, 0)
        turns = dict(zip(self.wanted.quantities, by_turn, strict=True))
        extremes = {
            name: values.min(axis=1) if name.endswith("_min") else values.max(axis=1)
            for name, values in turns.items()
        }
        sums = dict(zip(self.wanted.reductions, answers.sums.T, strict=True))
        yield self._of_slides(extremes, sums)
        yield self._of_drives(extremes, sums)
        yield self._of_joints(extremes, sums, points)
        yield self._of_energies(answers)
        if self.wanted.tracks:
            yield self._of_periods(answers, points)
        yield self._of_peaks(turns)

    def _of_peaks(self, turns: dict):
        """Means over turns of the largest sizes in each turn."""
        for body, direction in guides(self.record.scene).items():
            axis, share = along(direction)
            sizes = _sizes(turns, f"bodies/{body}/a{axis}") / abs(share)
            yield f"{body}_acceleration_peak_mean", sizes.mean(axis=1)
        for path in [
            n.removesuffix("_max") for n in turns if n.startswith("drives/") and n.endswith("_max")
        ]:
            _, drive, quantity = path.split("/")
            yield f"drive_{drive}_{quantity}_peak_mean", _sizes(turns, path).mean(axis=1)
        for joint in self.record.names("joints"):
            if (name := f"joints/{joint}/force_max") in turns:
                yield f"joint_{joint}_force_peak_mean", turns[name].mean(axis=1)

    def _of_slides(self, extremes: dict, sums: dict):
        for body, direction in guides(self.record.scene).items():
            axis, share = along(direction)
            ends = np.sort(
                [extremes[f"bodies/{body}/a{axis}_{end}"] / share for end in ("min", "max")], axis=0
            )
            yield f"{body}_acceleration_min", ends[0]
            yield f"{body}_acceleration_max", ends[1]
            if f"{body} far" in sums:
                yield f"{body}_position_deviation_max", sums[f"{body} far"]
                yield f"{body}_acceleration_deviation_rms", np.sqrt(sums[f"{body} beyond"])

    def _of_drives(self, extremes: dict, sums: dict):
        for drive in self.record.names("drives"):
            for quantity in ("torque", "force"):
                if (path := f"drives/{drive}/{quantity}") in sums:
                    yield f"drive_{drive}_{quantity}_min", extremes[f"{path}_min"]
                    yield f"drive_{drive}_{quantity}_max", extremes[f"{path}_max"]
                    yield f"drive_{drive}_{quantity}_rms", np.sqrt(sums[path])

    def _of_joints(self, extremes: dict, sums: dict, points: Points):
        for joint in self.record.names("joints"):
            if f"{joint} force" in sums:
                yield f"joint_{joint}_force_max", extremes[f"joints/{joint}/force_max"]
                yield f"joint_{joint}_force_rms", np.sqrt(sums[f"{joint} force"])
        for joint in self.mechanism.scene.clearance_joints:
            if f"{joint.name} contact" in sums:
                yield f"joint_{joint.name}_contact_fraction", sums[f"{joint.name} contact"]
            gap = extremes[f"joints/{joint.name}/gap_min"]
            yield f"joint_{joint.name}_gap_min", gap
            yield (
                f"joint_{joint.name}_eccentricity_ratio_max",
                1.0 - gap / self.number(points.par, joint, "clearance"),
            )
            if getattr(joint, "roughness", None) is not None:
                yield (
                    f"joint_{joint.name}_film_thickness_ratio_min",
                    gap / self.number(points.par, joint, "roughness"),
                )

    def _of_energies(self, answers: Answers):
        """Energy taken out in a turn; the first integral is what is put in."""
        spent = (answers.ended - answers.begun)[:, 1:] / self.turns
        for key, values in zip(self.mechanism.layout.dissipated, spent.T, strict=True):
            if key.startswith("joints/"):
                yield f"joint_{key.removeprefix('joints/')}_dissipated_per_turn", values
        yield "dissipated_per_turn", spent.sum(axis=1)

    def _of_periods(self, answers: Answers, points: Points):
        rows = []
        for index, tracks in enumerate(answers.tracks):
            record = Tracked(
                self, dict(zip(self.wanted.tracks, tracks, strict=True)), points, index
            )
            rows.append({name: value for name, value, *_ in periodicity(record, self.window)})
        for name in rows[0] if rows else ():
            yield name, np.array([row[name] for row in rows])

    def number(self, par: np.ndarray, part, name: str) -> np.ndarray:
        """A number of a part of the scene at points with these parameters; one that is folded in is
        the same.
        """
        row = self.mechanism.layout.parameters.get(f"{part.key}/{name}")
        return np.full(par.shape[1], getattr(part, name)) if row is None else par[row]

    def warnings(self, answers: Answers, points: Points) -> np.ndarray:
        """Number of warnings of each run: those of the first point's joints, and of its own
        films.
        """
        scene = self.mechanism.scene
        count = np.full(len(points.until), sum(len(j.doubts()) for j in scene.joints))
        for joint in scene.clearance_joints:
            if joint.film is not None and joint.film_joint is not None:
                count += self._film_warnings(joint, answers, points)
        return count

    def _near(self, answers: Answers, points: Points) -> np.ndarray:
        """True for runs in which surfaces with a contact law come near: see hole_warning."""
        near = np.zeros(len(points.until), bool)
        for joint in self.mechanism.scene.clearance_joints:
            if joint.contact is not None:
                rough = self.number(points.par, joint, "roughness") if joint.roughness else 0.0
                near |= self._of_all(answers, f"joints/{joint.name}/gap_min") < FULL_FILM * rough
        return near

    def _film_warnings(self, joint, answers: Answers, points: Points) -> np.ndarray:
        """As Regime.warnings: thin films, large pressures, flattened surfaces."""
        gap = self._of_all(answers, f"joints/{joint.name}/gap_min")
        pressure = self._of_all(answers, f"joints/{joint.name}/film_pressure_max")
        unit = regime(joint, 1.0, joint.clearance)  # of a pressure of 1 Pa at the thickest film
        thinnest = np.maximum(gap, 1e-9 * self.number(points.par, joint, "clearance"))
        flattening = unit.flattening_ratio * joint.clearance * pressure / thinnest
        counts = (unit.piezoviscous_number * pressure > PIEZOVISCOUS).astype(int) + (
            flattening > FLATTENING
        )
        if joint.roughness is not None:
            counts += gap / self.number(points.par, joint, "roughness") < FULL_FILM
        return counts


def _sizes(turns: dict, path: str) -> np.ndarray:
    """Largest size of a quantity in each turn."""
    return np.maximum(np.abs(turns[f"{path}_min"]), np.abs(turns[f"{path}_max"]))


class Tracked:
    """The part of a run that `periodicity` reads: offsets of its journals at its samples."""

    uneven, complete = False, True

    def __init__(self, summing: LaneMetrics, tracks: dict, points: Points, index: int):
        self.tracks, self.clearances = tracks, summing.record.clearances
        self.turn, until = float(points.turn[index]), points.until[index]
        samples = summing.span.samples
        self.time = np.arange(samples) * (until / (samples - 1))
        self.time[-1] = until
        sizes = {
            j.name: float(summing.number(points.par, j, "clearance")[index])
            for j in summing.mechanism.scene.clearance_joints
        }
        self.joints = {
            name: summing.record.described(name) | {"clearance": size}
            for name, size in sizes.items()
        }

    def described(self, joint: str) -> dict:
        """Description of a joint at this point."""
        return self.joints[joint]

    def values(self, path: str) -> np.ndarray:
        return self.tracks[path]

    def turns_at(self, time):
        return time / self.turn

    def time_at(self, turns):
        return turns * self.turn
