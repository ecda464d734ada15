"""Points of a sweep run side by side in lanes, with the metrics of the ordinary way.

One point is run the ordinary way; it tells which metrics there are, their units and texts. The
others differ from it in
numbers: their parameters are worked out with all values at once, and those of some points compared
with what building these one by one gives. Where that differs, or a scene, an option or a metric
does not suit lanes, the points are left to the ordinary way, and `Unsuited` says why. So is a point
that fails or whose energy does not add up.
"""

import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from clearance import lanes
from clearance.case import Case
from clearance.columns import Column, Mixed, values_of
from clearance.diagnosis import LOST_ENERGY
from clearance.extremes import along, guides
from clearance.lanes.group import Answers, Group, Points
from clearance.lanes.watch import Quantity, Reduction, Watch
from clearance.mechanism.numbers import numbers_of
from clearance.metrics import ROUNDING, Window, periodicity
from clearance.options import longest_step
from clearance.recording import MemoryRecord, MemorySink
from clearance.regimes import FLATTENING, FULL_FILM, PIEZOVISCOUS, regime
from clearance.scene import Scene
from clearance.simulation import prepare
from clearance.stepping import status
from clearance.stepping.state import CLEARANCE, PULL, RATE_X, RATE_Y
from clearance.sweeping.definition import Definition
from clearance.sweeping.ideal import ideal_motion
from clearance.sweeping.journal import DONE, Outcome
from clearance.sweeping.peaks import of_point

COMPARED = 6  # points whose numbers are compared with those of a scene built alone
SAME = 1e-9  # share within which natural sizes are the same
TOGETHER = 128  # points of a block, at least where memory allows
STEPS = 500_000  # of a block, about: a second
TRACKED = 2**24  # numbers of a block's turns and samples that are kept at a time
FEWEST = 24  # points that are worth machine code of their own
#: options of runs that lanes know
OPTIONS = {"turns", "rtol", "method", "samples_per_turn", "samples", "energy", "max_steps"}


class Unsuited(Exception):
    """The reason for which points cannot run in lanes."""


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
        first = self.layout.output[path]
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
            f"{joint} force", lambda p, row, given, own: row[c] * row[c] + row[c + 1] * row[c + 1]
        )

    def mean(self, name: str, value: Callable) -> None:
        self.reductions[name] = Reduction(value)

    def square(self, name: str, path: str) -> None:
        """Mean square of an output."""
        c = self.channel(path)
        self.mean(name, lambda p, row, given, own: row[c] * row[c])

    def watch(self, given: int, extra: int) -> Watch:
        return Watch(
            tuple(self.quantities.values()),
            tuple(self.reductions.values()),
            tuple(self.tracks.values()),
            given,
            extra,
        )


class Together:
    """Points of one structure in lanes.

    run: of the first, not begun; scene: that of all of them, its numbers columns; count: how many
        points. Raises Unsuited.
    """

    def __init__(self, first: Scene, scene: Scene, count: int, options: dict, settle: float | None):
        self.scene, self.count, self.settle, self.options = scene, count, settle, options
        self.run = prepare(first, **options)
        self.mechanism = self.run.mechanism
        if reason := lanes.impossible(self.mechanism, self.run.method):
            raise Unsuited(reason)
        self._record()
        self._check_window()
        self._want()
        self._make()

    # --- the first point
    def _record(self) -> None:
        run = prepare(self.mechanism.scene, **self.options)
        sink = MemorySink(run.mechanism.layout.channels, run.attributes())
        if failure := run.record(sink):
            raise Unsuited(f"its first point fails: {failure}")
        self.record: MemoryRecord = sink.record
        self.ideal = ideal_motion(run.mechanism.scene, run.span, self.record.scene)
        self.first = of_point(self.record, self.settle, self.ideal)
        self.steps = int(self.record.solver["steps"])

    def _check_window(self) -> None:
        """Metrics are about the last whole turns of the run, which begin with a turn."""
        window = Window.of(self.record, self.settle)
        turn, until = self.mechanism.scene.turn, self.run.span.until
        if window is None or not turn or window.turns is None or self.record.uneven:
            raise Unsuited("no drive turns at a constant speed")
        before = window.begin / turn
        self.past = round(before)  # turns before the window
        on_turn = abs(before - self.past) < ROUNDING
        if not on_turn or window.end < until * (1.0 - ROUNDING) or window.turns < 1.0 - ROUNDING:
            raise Unsuited("the run does not end with the whole turns that its metrics are about")
        self.turns = window.turns

    # --- what is looked at
    def _want(self) -> None:
        self.wanted = wanted = Wanted(self.mechanism.layout)
        output = self.mechanism.layout.output
        joints = [j for j in self.mechanism.scene.joints if f"joints/{j.name}/force_x" in output]
        for joint in joints:
            wanted.force(joint.name)
        for joint in self.mechanism.scene.clearance_joints:
            if joint.contact is not None:
                raise Unsuited(f"joint {joint.name} has a contact law")
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

            def far(p, row, given, own, x=x, y=y, dx=dx, dy=dy, k=2 * number):
                return p.size(row[x] * dx + row[y] * dy - given[k])

            def beyond(p, row, given, own, ax=ax, ay=ay, dx=dx, dy=dy, k=2 * number + 1):
                gap = row[ax] * dx + row[ay] * dy - given[k] * own[0]
                return gap * gap

            wanted.reductions[f"{body} far"] = Reduction(far, mean=False)
            wanted.reductions[f"{body} beyond"] = Reduction(beyond)

    # --- numbers of all points
    def _all(self, number) -> np.ndarray:
        """A number, or all its values, as an array of the points."""
        return np.broadcast_to(values_of(number), (self.count,)).astype(float)

    def _make(self) -> None:
        """Machine code, and the numbers of all points."""
        given = [row for pair in (self.ideal or {}).values() for row in pair]
        watch, span = self.wanted.watch(len(given), 1), self.run.span
        self.faster = np.ones(self.count)
        drives = [d for d in self.scene.drives if d.speed]
        if len(drives) == 1 == len(self.scene.drives):
            self.faster = self._all(drives[0].speed) / self.mechanism.scene.drives[0].speed
        self.group = Group(
            self.mechanism,
            self.run.method,
            self.run.solver.rtol,
            span.samples,
            watch,
            self.wanted.channels,
            np.array(given).reshape(len(given), -1),
        )
        self.points = self._points()
        self._film_rates()

    def _points(self) -> Points:
        """Numbers of all points; natural rates of films as they are without regard to damping."""
        mechanism, state = self.mechanism, self.run.state
        repeated = np.ones((1, self.count))
        turn, base = self._all(self.scene.turn), mechanism.scene.turn
        until = turn * (self.run.span.until / base)
        shape, spots = self.group.shape, self.scene.spots
        reach = np.array([self._all(spots[i][1].reach) for _, i in shape.films]).reshape(
            -1, self.count
        )
        self.frequency = self._frequencies()
        scale = self._scales()
        pull = mechanism.start.size * self.frequency**2 + math.hypot(*mechanism.scene.gravity)
        p = shape.coordinates
        films = {
            "clearance": reach,
            "pull": np.broadcast_to(pull, reach.shape).copy(),
            "rate_x": np.array([scale[p + first] for first, _ in shape.films]),
            "rate_y": np.array([scale[p + first + 1] for first, _ in shape.films]),
        }
        return Points(
            y=state.y[:, None] * repeated,
            scale=scale,
            par=self._parameters(),
            work=state.work[:, None] * repeated,
            films=films,
            longest=turn * (longest_step(mechanism, self.run.span) / base),
            begin=self.past * turn,
            until=until,
            turn=turn,
            own=self.faster[None] ** 2,
        )

    def _parameters(self) -> np.ndarray:
        """Parameters, those derived from them with them: (parameters, points)."""
        layout, mechanism = self.mechanism.layout, self.mechanism
        head = len(layout.parameters) + layout.derived
        par = np.repeat(mechanism.par[:head, None], self.count, axis=1)
        for name, number in numbers_of(self.scene):
            if (
                name in layout.parameters
                and isinstance(number, float)
                and hasattr(number, "values")
            ):
                par[layout.parameters[name]] = number.values
        with np.errstate(all="ignore"):
            derived = mechanism.structure.derive(list(par))
        return np.array([self._all_of(row) for row in derived])

    def _all_of(self, row) -> np.ndarray:
        return np.broadcast_to(np.asarray(row, float), (self.count,))

    def _frequencies(self) -> np.ndarray:
        """Typical angular frequencies, see Mechanism.frequency: motions of the start are those of
        the drive's speed.
        """
        start, gravity = self.mechanism.start, math.hypot(*self.mechanism.scene.gravity)
        rates = [abs(v[2]) for v in start.velocity.values()]
        rates += [abs(v[0]) / start.size for v in start.velocity.values()]
        rates += [abs(d.nominal) for d in self.mechanism.scene.drives if d.nominal]
        return np.maximum(max(rates) * np.abs(self.faster), math.sqrt(gravity / start.size))

    def _scales(self) -> np.ndarray:
        """Natural sizes of the states, see Mechanism.scale: (states, points)."""
        layout, plan, size = self.mechanism.layout, self.mechanism.plan, self.mechanism.start.size
        sizes = {f"{e.key}/{s.name}": s.size for e in self.scene.elements for s in e.states()}
        sizes |= {c.key: 1.0 if c.turns else size for c in plan.free}
        lengths = [self._all(sizes[name]) for name in layout.coordinates]
        first_order = [self._all(sizes[name]) for name in layout.first_order]
        return np.array([*lengths, *(x * self.frequency for x in lengths), *first_order])

    def _film_rates(self) -> None:
        """Natural rates of films, see Run._scale_film_rates."""
        points, mechanism, p = self.points, self.mechanism, self.group.shape.coordinates
        rest, films, usual = points.y.copy(), points.films, points.scale.copy()
        for at in mechanism.places.values():
            rest[at : at + 2] = rest[p + at : p + at + 2] = 0.0
        before = self.group.rates(points, rest)
        for row, (first, _) in enumerate(self.group.shape.films):
            for k, name in ((p + first, "rate_x"), (p + first + 1, "rate_y")):
                moved, share = rest.copy(), usual[k] / usual[p + first]
                moved[k] = usual[k]
                slope = np.abs(self.group.rates(points, moved)[k] - before[k])
                bound = films["pull"][row] * share
                rate = np.where(
                    slope > bound, bound * usual[k] / np.maximum(slope, 1e-300), usual[k]
                )
                points.scale[k] = films[name][row] = rate

    def compare(self, place: int, scene: Scene) -> None:
        """Compare the numbers of a point with those of its scene built alone.

        Raises Unsuited where they differ.
        """
        run = prepare(scene, **self.options)
        mechanism, points, n = run.mechanism, self.points, self.group.shape.states
        if mechanism.structure is not self.mechanism.structure:
            raise Unsuited("its points have different structures")
        head, state = len(points.par), run.state
        films = [i for _, i in self.group.shape.films]
        alone = {
            "parameters": (mechanism.par[:head], points.par[:, place], 1e-13),
            "tables": (mechanism.par[head:], self.mechanism.par[head:], 0.0),
            "start": (state.y, points.y[:, place], 0.0),
            "work": (state.work, points.work[:, place], SAME),
            "natural sizes": (state.scale[:n], points.scale[:, place], SAME),
            "times": (
                [run.span.until, state.longest_step, float(run.span.samples)],
                [points.until[place], points.longest[place], float(self.group.samples)],
                1e-12,
            ),
        }
        for column, name in (
            (CLEARANCE, "clearance"),
            (PULL, "pull"),
            (RATE_X, "rate_x"),
            (RATE_Y, "rate_y"),
        ):
            alone[f"film {name}"] = (
                state.contacts[films, column],
                points.films[name][:, place],
                SAME,
            )
        for what, (one, other, share) in alone.items():
            one, other = np.asarray(one), np.asarray(other)
            if one.shape != other.shape or (np.abs(one - other) > share * np.abs(one)).any():
                raise Unsuited(
                    f"the {what} of its points do not follow from its parameters one by one"
                )
        ideal = ideal_motion(mechanism.scene, run.span, mechanism.scene.description()) or {}
        for body, (place_of, rate) in (self.ideal or {}).items():
            if body not in ideal or not np.array_equal(ideal[body][0], place_of):
                raise Unsuited("the ideal motions of its points differ")
            faster = self.faster[place] ** 2
            if not np.allclose(
                ideal[body][1], rate * faster, rtol=1e-9, atol=1e-9 * np.abs(rate).max() * faster
            ):
                raise Unsuited("the ideal motions of its points differ")

    # --- results
    def blocks(self):
        """Places of the points, block by block."""
        numbers = len(self.wanted.tracks) * self.run.span.samples
        numbers += len(self.wanted.quantities) * self.points.turns
        size = min(max(TRACKED // numbers, 1), max(STEPS // self.steps, TOGETHER))
        return (np.arange(self.count)[i : i + size] for i in range(0, self.count, size))

    def answers(self, places: np.ndarray, threads: int) -> Answers:
        """Results of some of the points."""
        points = self.points
        part = Points(
            y=points.y[:, places],
            scale=points.scale[:, places],
            par=points.par[:, places],
            work=points.work[:, places],
            films={name: values[:, places] for name, values in points.films.items()},
            longest=points.longest[places],
            begin=points.begin[places],
            until=points.until[places],
            turn=points.turn[places],
            own=points.own[:, places],
        )
        return self.group.run(part, threads, self.options.get("max_steps"))

    def sound(self, answers: Answers) -> np.ndarray:
        """True for runs that reached their end and whose energy adds up."""
        good = answers.status == status.DONE
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
        doubt = max(LOST_ENERGY, 100.0 * self.run.solver.rtol)
        return good & (ends["residual_max"] - ends["residual_min"] <= doubt * turned)

    def _of_all(self, answers: Answers, name: str, first: int = 0) -> np.ndarray:
        """Outermost of the extremes of a quantity in the turns from one on."""
        values = answers.extremes[:, first:, list(self.wanted.quantities).index(name)]
        return values.min(axis=1) if name.endswith("_min") else values.max(axis=1)

    def metrics(self, answers: Answers, places: np.ndarray) -> dict[str, np.ndarray]:
        """Metrics of the points by name, as the first point has them.

        Raises Unsuited for others.
        """
        made = {name: values for part in self._parts(answers, places) for name, values in part}
        if missing := [name for name in self.first if name not in made]:
            raise Unsuited(f"metric {missing[0]} is not made in lanes")
        return {name: made[name] for name in self.first}

    def _parts(self, answers: Answers, places: np.ndarray):
        by_turn = np.moveaxis(answers.extremes[:, self.past :], -1, 0)
        turns = dict(zip(self.wanted.quantities, by_turn, strict=True))
        extremes = {
            name: values.min(axis=1) if name.endswith("_min") else values.max(axis=1)
            for name, values in turns.items()
        }
        sums = dict(zip(self.wanted.reductions, answers.sums.T, strict=True))
        yield self._of_slides(extremes, sums)
        yield self._of_drives(extremes, sums)
        yield self._of_joints(extremes, sums, places)
        yield self._of_energies(answers)
        if self.wanted.tracks:
            yield self._of_periods(answers, places)
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

    def _of_joints(self, extremes: dict, sums: dict, places: np.ndarray):
        for joint in self.record.names("joints"):
            if f"{joint} force" in sums:
                yield f"joint_{joint}_force_max", extremes[f"joints/{joint}/force_max"]
                yield f"joint_{joint}_force_rms", np.sqrt(sums[f"{joint} force"])
        for joint in self.scene.clearance_joints:
            gap = extremes[f"joints/{joint.name}/gap_min"]
            yield f"joint_{joint.name}_gap_min", gap
            yield (
                f"joint_{joint.name}_eccentricity_ratio_max",
                1.0 - gap / self._all(joint.clearance)[places],
            )
            if getattr(joint, "roughness", None) is not None:
                yield (
                    f"joint_{joint.name}_film_thickness_ratio_min",
                    gap / self._all(joint.roughness)[places],
                )

    def _of_energies(self, answers: Answers):
        """Energy taken out in a turn; the first integral is what is put in."""
        spent = (answers.ended - answers.begun)[:, 1:] / self.turns
        for key, values in zip(self.mechanism.layout.dissipated, spent.T, strict=True):
            if key.startswith("joints/"):
                yield f"joint_{key.removeprefix('joints/')}_dissipated_per_turn", values
        yield "dissipated_per_turn", spent.sum(axis=1)

    def _of_periods(self, answers: Answers, places: np.ndarray):
        rows = []
        for tracks, place in zip(answers.tracks, places, strict=True):
            record = Tracked(self, dict(zip(self.wanted.tracks, tracks, strict=True)), int(place))
            window = Window.of(record, self.settle)
            rows.append({name: value for name, value, *_ in periodicity(record, window)})
        for name in rows[0] if rows else ():
            yield name, np.array([row[name] for row in rows])

    def warnings(self, answers: Answers, places: np.ndarray) -> np.ndarray:
        """Number of warnings of each run: those of the first point's joints, and of its own films."""
        count = np.zeros(len(places), int)
        joints = zip(
            self.mechanism.scene.clearance_joints, self.scene.clearance_joints, strict=True
        )
        count += sum(len(j.doubts()) for j in self.mechanism.scene.joints)
        for one, many in joints:
            if one.film is None or one.film_joint is None:
                continue
            gap = self._of_all(answers, f"joints/{one.name}/gap_min")
            pressure = self._of_all(answers, f"joints/{one.name}/film_pressure_max")
            count += self._film_warnings(one, many, pressure, gap, places)
        return count

    def _film_warnings(
        self, one, many, pressure: np.ndarray, gap: np.ndarray, places: np.ndarray
    ) -> np.ndarray:
        """As Regime.warnings: thin films, large pressures, flattened surfaces."""
        unit = regime(one, 1.0, one.clearance)  # of a pressure of 1 Pa at the thickest film
        thinnest = np.maximum(gap, 1e-9 * self._all(many.clearance)[places])
        flattening = unit.flattening_ratio * one.clearance * pressure / thinnest
        counts = (unit.piezoviscous_number * pressure > PIEZOVISCOUS).astype(int) + (
            flattening > FLATTENING
        )
        if one.roughness is not None:
            counts += gap / self._all(many.roughness)[places] < FULL_FILM
        return counts


def _sizes(turns: dict, path: str) -> np.ndarray:
    """Largest size of a quantity in each turn."""
    return np.maximum(np.abs(turns[f"{path}_min"]), np.abs(turns[f"{path}_max"]))


class Tracked:
    """The part of a run that `periodicity` reads: offsets of its journals at its samples."""

    uneven, complete = False, True

    def __init__(self, together: Together, tracks: dict[str, np.ndarray], place: int):
        self.tracks, self.clearances = tracks, together.record.clearances
        self.turn = float(together._all(together.scene.turn)[place])
        until, samples = together.points.until[place], together.run.span.samples
        self.time = np.arange(samples) * (until / (samples - 1))
        self.time[-1] = until
        sizes = {
            j.name: float(together._all(j.clearance)[place])
            for j in together.scene.clearance_joints
        }
        described = together.record.scene["joints"]
        self.scene = {
            "joints": [
                j | {"clearance": sizes[j["name"]]} if j["name"] in sizes else j for j in described
            ]
        }

    def values(self, path: str) -> np.ndarray:
        return self.tracks[path]

    def turns_at(self, time):
        return time / self.turn

    def time_at(self, turns):
        return turns * self.turn


# --- a sweep's points
class Lanes:
    """Points of a sweep in lanes, as far as they suit.

    case: of the definition; about: what all its points are made from. reasons: why points are left
        to the ordinary way.
    """

    def __init__(self, definition: Definition, case: Case, about: dict):
        self.definition, self.case, self.about = definition, case, about
        self.reasons: dict[str, int] = {}
        self.count = 0  # points that ran in lanes

    def outcomes(self, pending: Sequence[int], threads: int) -> Iterator[list[Outcome]]:
        """Outcomes of those that suit, block by block."""
        if os.environ.get("CLEARANCE_LANES") == "0":
            return
        for group in self._groups(pending):
            try:
                yield from self._run(group, threads)
            except (Unsuited, Mixed) as error:
                self._left(str(error), len(group))
            except (
                ValueError,
                TypeError,
            ) as error:  # a scene that takes no column, or is impossible
                self._left(f"their numbers are not worked out together ({error})", len(group))

    def _left(self, reason: str, count: int) -> None:
        self.reasons[reason] = self.reasons.get(reason, 0) + count

    def _groups(self, pending: Sequence[int]) -> list[list[int]]:
        """Points that differ in real numbers only; small groups are left out."""
        definition = self.definition
        if definition.files or definition.own:
            self._left(
                "runs have files" if definition.files else "metrics of your own", len(pending)
            )
            return []
        if unknown := sorted(set(definition.options) - OPTIONS):
            self._left(f"option {unknown[0]}", len(pending))
            return []
        if "turns" not in definition.options:
            self._left("their length is not in turns", len(pending))
            return []
        columns = definition.points.columns
        fixed = [
            n for n, values in columns.items() if not all(isinstance(v, float) for v in values)
        ]
        groups: dict[tuple, list[int]] = {}
        for index in pending:
            groups.setdefault(tuple(columns[n][index] for n in fixed), []).append(index)
        for group in groups.values():
            if len(group) < FEWEST:
                self._left(f"fewer than {FEWEST} of a kind", len(group))
        return [group for group in groups.values() if len(group) >= FEWEST]

    def _scene(self, group: list[int]) -> Scene:
        """The scene of all points of a group."""
        values = self.definition.values(group[0])
        for name, column in self.definition.points.columns.items():
            numbers = [column[i] for i in group]
            if isinstance(numbers[0], float) and len(set(numbers)) > 1:
                values[name] = Column(np.array(numbers))
        return self.case.scene(**values)

    def _run(self, group: list[int], threads: int) -> Iterator[list[Outcome]]:
        definition = self.definition
        first = self.case.scene(**definition.values(group[0]))
        together = Together(
            first, self._scene(group), len(group), definition.options, definition.settle
        )
        for place in np.unique(np.linspace(0, len(group) - 1, COMPARED).astype(int)):
            together.compare(int(place), self.case.scene(**definition.values(group[place])))
        for places in together.blocks():
            began = time.perf_counter()
            answers = together.answers(places, threads)
            good = together.sound(answers)
            if not good.all():
                self._left("they failed or are in doubt", int((~good).sum()))
            made = self._made(
                together, answers, places, good, (time.perf_counter() - began) / len(places)
            )
            yield [
                replace(o, index=group[o.index], key=definition.keys[group[o.index]]) for o in made
            ]
            self.count += len(made)

    def _made(
        self, together: Together, answers: Answers, places, good, wall: float
    ) -> list[Outcome]:
        """Outcomes of a block; their index is the place in the group."""
        values, warnings = together.metrics(answers, places), together.warnings(answers, places)
        described = {name: (m.units, m.text) for name, m in together.first.items()}
        about = self.about | {"text": together.mechanism.structure.digest}
        rows = zip(*(values[name].tolist() for name in described), strict=True)
        made = []
        for i, row in enumerate(rows):
            if good[i]:
                metrics, steps = dict(zip(described, row, strict=True)), int(answers.steps[i])
                made.append(
                    Outcome(
                        int(places[i]),
                        "",
                        DONE,
                        "",
                        metrics,
                        {} if made else described,
                        int(warnings[i]),
                        wall,
                        wall,
                        steps,
                        made=about,
                    )
                )
        return made

    def report(self) -> str:
        """Number of points that ran in lanes, and the reasons of the others."""
        left = "; ".join(f"{count}: {reason}" for reason, count in self.reasons.items())
        return f"{self.count} points in lanes" + (f"; the ordinary way for {left}" if left else "")
