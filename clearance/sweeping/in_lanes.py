"""Points of a sweep run side by side in lanes, with the metrics of the ordinary way.

The points differ in numbers, which come as arrays (lanes/point_numbers.py); their metrics come from
what lanes keep (lanes/lane_metrics.py). Where a scene, an option or a metric does not suit lanes,
the points run the ordinary way, and `NotForLanes` gives the reason. So do points that fail or whose
energy does not add up.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from clearance import lanes
from clearance.accuracy.companion import companion_rtol, film_factor
from clearance.accuracy.request import LOST
from clearance.film.lookup import Tabulated
from clearance.lanes.code import chosen_width, natural_width, off
from clearance.lanes.group import FILMS, Answers, Group, Points, with_derived
from clearance.lanes.ideal_lanes import IdealMotions
from clearance.lanes.lane_metrics import LaneMetrics
from clearance.lanes.point_numbers import SCALARS, NotForLanes, PointNumbers
from clearance.lanes.possible import possible
from clearance.machine.threads import at_once
from clearance.mechanism.build import acceleration_of, tables_of
from clearance.metrics.metrics import described
from clearance.run.options import SAMPLES_PER_TURN, Span, longest_step, samples_in
from clearance.run.run import Run
from clearance.scene.case import Case
from clearance.scene.scene import Scene
from clearance.simulation import prepare
from clearance.stepping import status
from clearance.sweeping.definition import FEWEST, Definition
from clearance.sweeping.journal import Block, Ways
from clearance.sweeping.requested import Ladder, Reached
from clearance.values.columns import Column, Mixed
from clearance.values.spots import BLENDED

EXACT = 1e-12  # share within which numbers of the starts are the same
SAME = 1e-9  # the same of natural sizes that come of a kernel
FULL = 32  # points that a thread takes at a time, at least where memory allows
TOGETHER = 128  # points of a block, at least where memory allows
STEPS = 500_000  # of a block, about: a second
LONG = 5000  # steps of a run beside which the time to prepare it, by one process, is short
FAR_MORE = 100  # times the steps of the first point, after which one runs the ordinary way
COMPARED = 4  # points whose ideal motions are worked out the ordinary way too
TRACKED = 2**24  # numbers of a block's turns and samples that are stored at a time
#: methods that single stiff runs choose; that of lanes
SINGLE, STIFF = {"rodas5p", "radau9"}, "radau5"
#: options of runs that lanes have
OPTIONS = {"turns", "until", "rtol", "method", "samples_per_turn", "samples", "energy", "max_steps"}


def middle_of(columns: dict[str, np.ndarray]) -> int:
    """Place of the middle one of points ordered by their values: the same in any order."""
    order = np.lexsort([columns[name] for name in sorted(columns)])
    return int(order[len(order) // 2])


class Together:
    """Points of one structure in lanes.

    scene: gives the scene of swept values; columns: all values of the swept numbers by name;
        options: of the runs, as of `prepare`; settle: turns left out of the
        metrics; error: that is to be stated, as of `simulate`.
    first: place of the point that is run the ordinary way too. Raises NotForLanes.
    """

    def __init__(
        self,
        scene: Callable[[dict], Scene],
        columns: dict[str, np.ndarray],
        options: dict,
        settle: float | None,
        error: float | str | dict | None = None,
    ):
        self.columns, self.options, self.scene_of = columns, options, scene
        self.count = len(next(iter(columns.values())))
        self.first = middle_of(columns)
        first = {name: column[self.first].item() for name, column in columns.items()}
        trials: dict[tuple, tuple[dict, Run]] = {}

        def alone(values: dict) -> Run:
            return prepare(scene(values), **options)

        def prepared(values: dict) -> Run:
            key = tuple(values.items())
            if key not in trials:
                trials[key] = values, alone(values)
            return trials[key][1]

        run = prepare(scene(first), **options)
        if options.get("method", "auto") == "auto" and run.method.current in SINGLE:
            self.options = options = options | {"method": STIFF}
            run = prepare(scene(first), **options)
        if reason := lanes.impossible(run.mechanism, run.method.current):
            raise NotForLanes(reason)
        self.summing = LaneMetrics(run, settle, error)
        #: runs may have other turns than the first
        self.lengths = "turns" not in options and run.mechanism.scene.turn is not None
        self.spread = self._spread(prepared, first)
        self.spread.prepared = alone  # from now on
        tried = list(trials.values())
        films = [list(map(id, run.mechanism.sources.values())) for _, run in tried]
        self.several = any(tables != films[0] for tables in films)
        turning = SCALARS.index("turn") in self.spread.varying("scalars")
        self.lengths &= turning
        if self.lengths:
            self._begin_with_most(settle, error)
        moves = self.spread.moves or run.mechanism.scene.turn is None or self.lengths
        self.ideal = self._ideal() if self.summing.ideal and moves else None
        #: warnings of a scene; not a number where points differ in them
        self.doubts = _alike({len(run.mechanism.scene.doubts) for _, run in tried})
        self.run = self.spread.run
        self.mechanism = self.run.mechanism
        varying, count = self.spread.varying("numbers"), len(self.mechanism.layout.parameters)
        self.group = Group(
            self.mechanism,
            self.run.method.current,
            self.run.solver.rtol,
            self.summing.span.samples,
            self.summing.watch,
            self.summing.wanted.channels,
            self.summing.ideal_rows,
            shared=sorted(set(range(count)) - set(varying)),
            starts=self._starts() if self.several else (),
            moving=self._moving() if self.summing.stated else (),
        )
        self._compare(tried)

    def _begin_with_most(self, settle: float | None, error: float | str | dict | None) -> None:
        """Metrics are those of the point with the most turns."""
        turn = self.spread.starts(self.columns)["scalars"].T[SCALARS.index("turn")]
        self.first = int(np.argmin(turn))
        first = {name: column[self.first].item() for name, column in self.columns.items()}
        self.summing = LaneMetrics(self.spread.prepared(first), settle, error)

    def _spread(self, prepared: Callable[[dict], Run], first: dict[str, float]) -> PointNumbers:
        """Starts of all points: bit for bit those of single runs where the sweep has them so.

        Steps follow the last bits of a start, and bits within a share would depend on `first`.
        """
        about = self.scene_of, prepared, self.columns
        even = not self.lengths
        try:
            return PointNumbers(*about, 0.0, first, even=even)
        except NotForLanes:
            try:
                return PointNumbers(*about, EXACT, first, even=even)
            except NotForLanes:
                if self.summing.steps < LONG:
                    raise
                return PointNumbers(*about, EXACT, first, alone=True, even=even)

    def _ideal(self) -> IdealMotions:
        """Ideal motions of points that differ in lengths."""
        if any(path[0] == "joints" and path[2] in ("axis", "angle") for path in self.spread.paths):
            raise NotForLanes("the direction of a guide is swept")
        return IdealMotions(self.spread.run.mechanism.scene, self.summing.span.samples)

    # --- numbers of points
    def points(
        self,
        columns: dict[str, np.ndarray],
        rtol: float | np.ndarray | None = None,
        tables: np.ndarray | None = None,
    ) -> Points:
        """Numbers of points, from their swept numbers; rtol, tables: where they have others."""
        mechanism, start = self.mechanism, self.spread.starts(columns)
        turn, frequency, size, _ = start["scalars"].T
        turns, uneven = self.mechanism.scene.turn is not None, self.summing.record.uneven
        until = self.options["turns"] * turn if "turns" in self.options else self.run.span.until
        until = np.broadcast_to(until, turn.shape)
        scale, reach, p = self._scales(start), start["reach"].T, self.group.shape.coordinates
        pull = acceleration_of(size, frequency, mechanism.scene.gravity)
        shape, parameters = self.group.shape, with_derived(mechanism, start["numbers"].T)
        films = {
            "clearance": reach[[i for _, i in shape.films]],
            "pull": np.tile(pull, (len(shape.films), 1)),
            "rate_x": scale[[p + first for first, _ in shape.films]],
            "rate_y": scale[[p + first + 1 for first, _ in shape.films]],
        }
        periods = turn.tolist() if turns else [None] * len(until)
        samples = np.full(until.shape, self.group.samples)
        if self.lengths:
            samples = self._samples(until / turn)
        spans = list(map(Span, until.tolist(), samples.tolist()))
        past, count = None, None
        if turns and not uneven:
            settle, count = self.summing.whole_turns(until / turn)
            past = settle.astype(int)
        longest = map(partial(longest_step, mechanism), spans, periods)
        points = Points(
            y=np.ascontiguousarray(start["state"].T),
            scale=scale,
            par=parameters,
            work=self._work(start["work"].T, reach, frequency),
            films=films,
            longest=np.array(list(longest)),
            begin=np.zeros_like(turn) if past is None else past * turn,
            until=until,
            turn=turn if turns else until,
            ends=until[:, None].copy() if uneven else None,
            frequency=frequency,
            numbers=self._faster(parameters)[None] ** 2,
            tables=self._tables(columns) if self.several and tables is None else tables,
            ideal=self._motions(columns, until, samples),
            rtol=rtol,
            past=past,
            count=count,
            samples=samples,
        )
        self._film_rates(points, pull)
        return points

    def _samples(self, turns: np.ndarray) -> np.ndarray:
        """Numbers of samples of runs of so many turns."""
        if (samples := self.options.get("samples")) is not None:
            return np.full(turns.shape, int(samples))
        every = self.options.get("samples_per_turn", SAMPLES_PER_TURN)
        return samples_in(every * turns).astype(int)

    def _motions(
        self, columns: dict[str, np.ndarray], until: np.ndarray, samples: np.ndarray
    ) -> np.ndarray | None:
        """Ideal motions of points, where they differ: (points, numbers, samples)."""
        if self.ideal is None:
            return None
        scene = self.scene_of({name: Column(values) for name, values in columns.items()})
        return self.ideal.along(scene, until, samples)

    def _work(self, work: np.ndarray, reach: np.ndarray, frequency: np.ndarray) -> np.ndarray:
        """Work vectors, see Mechanism.blend, and one more number: (numbers, points)."""
        vectors = np.vstack([work, np.zeros_like(frequency)])
        for i, (_, spot) in enumerate(self.mechanism.spots):
            if spot.kind == BLENDED:
                vectors[i] = np.maximum(spot.speed, reach[i] * frequency)
        return vectors

    def _starts(self) -> list[int]:
        """Places of the parameters that point to tables."""
        parameters = self.mechanism.layout.parameters
        return [parameters[f"{joint.key}/film/start"] for joint in self.mechanism.sources]

    def _moving(self) -> list[int]:
        """Places of the numbers of tables that are not those of stronger films."""
        if not (tables := tables_of(self.mechanism.scene)):
            return []
        _, stronger = _strengthened(tables)
        before = self.mechanism.par[-stronger.size :]
        return (len(self.mechanism.par) - before.size + np.flatnonzero(before != stronger)).tolist()

    def _scenes(self, columns: dict[str, np.ndarray]) -> Iterator[Scene]:
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        return (self.scene_of(dict(zip(columns, row, strict=True))) for row in rows)

    def _tables(self, columns: dict[str, np.ndarray]) -> np.ndarray:
        """Tables of points that have tables of their own: (points, numbers)."""
        scenes = self._scenes(columns)
        return np.array([np.concatenate([t.numbers for t in tables_of(s)]) for s in scenes])

    def stronger(self, columns: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray] | None:
        """Times of their errors by which the tables of points are made stronger, and the tables;
        None without tables.
        """
        if not tables_of(self.mechanism.scene):
            return None
        if not self.several:
            return _strengthened(tables_of(self.mechanism.scene))
        pairs = [_strengthened(tables_of(scene)) for scene in self._scenes(columns)]
        times, tables = zip(*pairs, strict=True)
        return np.array(times), np.array(tables)

    def _faster(self, par: np.ndarray) -> np.ndarray:
        """Speeds of the one drive that moves everything, over that of the first point."""
        drives = self.mechanism.scene.drives
        if len(drives) != 1 or not drives[0].speed:
            return np.ones(par.shape[1])
        return self.summing.number(par, drives[0], "speed") / drives[0].speed

    def _scales(self, start: dict[str, np.ndarray]) -> np.ndarray:
        """Natural sizes of the states, see Mechanism.scale: (states, points)."""
        sizes, p = start["sizes"].T, self.group.shape.coordinates
        return np.concatenate([sizes[:p], sizes[:p] * start["scalars"].T[1], sizes[p:]])

    def _film_rates(self, points: Points, pull: np.ndarray) -> None:
        """Natural rates of films, see Run._scale_film_rates; pull: typical accelerations."""
        mechanism, p = self.mechanism, self.group.shape.coordinates
        rest, usual = points.y.copy(), points.scale.copy()
        for at in mechanism.places.values():
            rest[at : at + 2] = rest[p + at : p + at + 2] = 0.0
        before = self.group.rates(points, rest)
        for first in (at for joint, at in mechanism.places.items() if joint.film is not None):
            for k in (p + first, p + first + 1):
                moved, share = rest.copy(), usual[k] / usual[p + first]
                moved[k] = usual[k]
                slope, bound = np.abs(self.group.rates(points, moved)[k] - before[k]), pull * share
                slower = bound * usual[k] / np.maximum(slope, 1e-300)
                points.scale[k] = np.where(slope > bound, slower, usual[k])
        for row, (first, _) in enumerate(self.group.shape.films):
            for k, name in ((p + first, "rate_x"), (p + first + 1, "rate_y")):
                points.films[name][row] = points.scale[k]

    def _compare(self, tried: list[tuple[dict, Run]]) -> None:
        """Compare numbers of runs with those of points. Raises NotForLanes where they differ."""
        names = self.columns
        points = self.points({n: np.array([values[n] for values, _ in tried]) for n in names})
        head, n = len(points.par), self.group.shape.states
        tables = points.tables if self.several else [self.mechanism.par[head:]] * len(tried)
        films = [i for _, i in self.group.shape.films]
        rounded, least = self.spread.parts(self.spread.rounded), np.zeros(head)
        least[: rounded["numbers"].size] = rounded["numbers"]
        least_of = {"parameters": least, "start": rounded["state"]}
        for index, (_, run) in enumerate(tried):
            state = run.state
            pairs = {
                "parameters": (run.mechanism.par[:head], points.par[:, index]),
                "tables": (run.mechanism.par[head:], tables[index]),
                "start": (state.y, points.y[:, index]),
                "work": (state.work, points.work[:, index]),
                "natural sizes": (state.scale[:n], points.scale[:, index]),
                "length": (run.span.until, points.until[index]),
                "samples": (run.span.samples, points.samples[index]),
                "longest step": (state.longest_step, points.longest[index]),
            }
            pairs |= {
                f"film {name}": (state.contacts[films, column], points.films[name][:, index])
                for name, column in FILMS.items()
            }
            for text, (a, b) in pairs.items():
                a, b = np.asarray(a), np.asarray(b)
                sizes = np.maximum(np.abs(a), least_of.get(text, 0.0))
                if a.shape != b.shape or (np.abs(a - b) > SAME * sizes).any():
                    raise NotForLanes(f"the {text} of its points do not follow from its parameters")
        for index in range(0, len(tried), -(-len(tried) // COMPARED)) if self.ideal else ():
            self.ideal.compare(tried[index][1], points.ideal[index])

    # --- results
    @property
    def block(self) -> int:
        """Number of points that are run at a time."""
        ideal = self.summing.ideal_rows.size if self.ideal else 0
        room = max(TRACKED // max(self.summing.kept + ideal, 1), 1)
        return min(room, max(STEPS // self.summing.steps, TOGETHER))

    def answers(self, points: Points) -> Answers:
        """Results of points; one that takes far more steps than the first may never end."""
        limit = max(FAR_MORE * self.summing.steps, STEPS)
        limit = min(self.options.get("max_steps") or limit, limit)
        answers = self.group.run(points, limit)
        return self._by_angle(points, answers, limit) if self.summing.record.uneven else answers

    def _by_angle(self, points: Points, answers: Answers, limit: int) -> Answers:
        """Results of points with finite drives. They run once more, up to the turns that they have
        made; their first turn here is the entire run.
        """
        ends, settle, count = self.summing.ends_of_turns(answers, points)
        good = np.flatnonzero(count)
        ends[count == 0, 0] = points.until[count == 0]
        edges, last = np.insert(ends, 0, 0.0, axis=1), settle + count
        points.length, points.until, points.ends = points.until, points.until.copy(), ends
        points.until[good] = edges[good, last[good]]
        points.begin[good] = edges[good, settle[good]]
        turns = self.group.run(points, limit)
        first = points.y[len(points.y) - answers.ledgers.shape[-1] :].T[:, None]
        points.past, points.count = 1 + settle, count
        points.ends = np.concatenate([np.zeros((len(count), 1)), ends], axis=1)
        return replace(
            answers,
            extremes=np.concatenate([answers.extremes, turns.extremes], axis=1),
            totals=np.concatenate([np.zeros_like(answers.totals), turns.totals], axis=1),
            ledgers=np.concatenate([first, turns.ledgers], axis=1),
            status=np.where(count > 0, turns.status, status.NOT_FINITE),
        )

    def warnings(
        self, columns: dict[str, np.ndarray], answers: Answers, points: Points
    ) -> np.ndarray:
        """Number of warnings of each run, those of its scene with them."""
        data, par = self.group.placed(points)
        doubts = np.full(len(points.until), self.doubts)
        if math.isnan(self.doubts):
            doubts = np.array([len(scene.doubts) for scene in self._scenes(columns)])
        warnings = self.summing.warnings(answers, replace(points, par=par), data)
        return warnings + doubts.astype(int)

    def errors(self, columns: dict[str, np.ndarray], answers: Answers) -> dict[str, np.ndarray]:
        """Stated errors of points that have run, see accuracy/companion.py; not a number where a
        companion fails.
        """
        rtol = companion_rtol(self.run.solver.rtol)
        points = self.points(columns, rtol)
        companions = film = self.answers(points)
        good, times = companions.status == status.DONE, np.ones(len(points.until))
        if strong := self.stronger(columns):
            times, tables = strong
            film = self.answers(self.points(columns, rtol, tables))
            good &= film.status == status.DONE
        stated = self.summing.errors((answers, companions, film), points, times)
        return {name: np.where(good, values, np.nan) for name, values in stated.items()}


def _blocks(indices: list[int], size: int, threads: int) -> Iterator[list[int]]:
    """Parts of the points, as many to a thread as suit the memory; neighbours, which take about as
    long, go to different threads. The last parts are smaller, so that all threads end together.
    """
    most = max(size // threads, min(size, FULL))
    while indices:
        rest = max(len(indices) // (2 * threads), 2 * FULL) if threads > 1 else most
        count = min(most, rest) * threads
        several, indices = indices[:count], indices[count:]
        yield from (several[k::threads] for k in range(min(threads, len(several))))


def _strengthened(tables: list) -> tuple[float, np.ndarray]:
    """Times of their errors by which film tables are made stronger, and their numbers then."""
    times = film_factor(t for t in tables if isinstance(t, Tabulated))
    parts = [
        t.stronger(1.0 + times * t.error) if isinstance(t, Tabulated) and times else t.numbers
        for t in tables
    ]
    return times or 1.0, np.concatenate(parts)


def _joined(arrays: Iterator[np.ndarray]) -> np.ndarray:
    """Arrays one behind the other, of which there may be none."""
    return np.concatenate([[], *arrays])


def _alike(numbers: set[float]) -> float:
    """The only one of some numbers; not a number where there are several."""
    return numbers.pop() if len(numbers) == 1 else math.nan


class Lanes:
    """Points of a sweep in lanes, as far as they suit.

    Groups and their first points are those of all points, whichever are still to be run: no number
    depends on a restart.

    case: of the definition; about: what all its points are made from.
    """

    def __init__(self, definition: Definition, case: Case, about: dict):
        self.definition, self.case, self.about = definition, case, about
        self.ways = Ways(lanes=0 if off() else natural_width())
        columns = definition.points.columns
        self.numbers = {n: np.array(columns[n]) for n in definition.spread}
        fixed = [v for v in columns.values() if not all(isinstance(number, float) for number in v)]
        self.kinds = list(zip(*fixed, strict=True)) or [()] * len(definition.points)
        self.groups: dict[tuple, Together | str] = {}

    def blocks(self, pending: Sequence[int], threads: int) -> Iterator[Block]:
        """Those that suit, block by block, a block in each thread; they have no keys yet."""
        for together, indices in self._suited(pending):
            parts = _blocks(indices, together.block, threads)
            try:
                for part, block in at_once(partial(self._run, together), parts, threads):
                    if rest := len(part) - len(block.keys):
                        self.ways.alone(self._reason(together), rest)
                    yield block
            except (NotForLanes, Mixed) as error:
                self.ways.alone(str(error), len(indices))

    @staticmethod
    def _reason(together: Together) -> str:
        """The reason for which points of a block take the ordinary way."""
        if together.summing.request is None:
            uneven = together.lengths or together.summing.record.uneven
            other = "made other turns, " if uneven else ""
            return f"they failed, {other}carry a warning or press too deep"
        return f"they failed, or do not reach the requested errors by rtol {LOST:g}"

    def suited(self, pending: Sequence[int]) -> list[int]:
        """Those that suit."""
        return [index for _, indices in self._suited(pending) for index in indices]

    def _suited(self, pending: Sequence[int]) -> Iterator[tuple[Together, list[int]]]:
        """Points that differ in real numbers only, group by group."""
        if reason := self._unfit():
            self.ways.alone(reason, len(pending))
            return
        members: dict[tuple, list[int]] = {}
        for index in pending:
            members.setdefault(self.kinds[index], []).append(index)
        for kind, indices in members.items():
            if kind not in self.groups:
                self.groups[kind] = self._together(kind)
            if isinstance(together := self.groups[kind], str):
                self.ways.alone(together, len(indices))
                continue
            has = together.spread.has({n: self.numbers[n][indices] for n in together.columns})
            if not has.all():
                self.ways.alone("their values are impossible", int((~has).sum()))
            yield together, np.array(indices)[has].tolist()

    def _unfit(self) -> str:
        """The reason why no point of the sweep can go in lanes; none where some may."""
        definition = self.definition
        if off():
            return "lanes are off (CLEARANCE_LANES=0)"
        if definition.files or definition.own:
            return "runs have files" if definition.files else "metrics of your own"
        if unknown := sorted(set(definition.options) - OPTIONS - {"error"}):
            return f"option {unknown[0]}"
        return ""

    def _together(self, kind: tuple) -> Together | str:
        """All points of a kind; the reason where they do not suit."""
        group = [index for index, candidate in enumerate(self.kinds) if candidate == kind]
        if len(group) < FEWEST:
            return f"fewer than {FEWEST} of a kind"
        values, options = self.definition.values(group[0]), self.definition.run_options

        def scene(swept: dict) -> Scene:
            return self.case.scene(**(values | swept))

        columns = {n: v[group] for n, v in self.numbers.items() if np.ptp(v[group])}
        good = possible(lambda swept: prepare(scene(swept), **options), columns)
        if good.sum() < FEWEST:
            return f"fewer than {FEWEST} have possible values"
        try:
            return Together(
                scene,
                {n: v[good] for n, v in columns.items()},
                options,
                self.definition.settle,
                self.definition.options.get("error"),
            )
        except NotForLanes as error:
            return str(error)
        except (ValueError, TypeError) as error:  # an impossible scene
            return f"their numbers are not worked out together ({error})"

    def _run(self, together: Together, indices: list[int]) -> Block:
        """Points of a block, those that are sound."""
        began, summing = time.perf_counter(), together.summing
        columns = {n: self.numbers[n][indices] for n in together.columns}
        about, text = described(summing.first | summing.stated), together.mechanism.structure.digest
        parts = list(self._parts(together, columns))
        places = _joined(part.places for part in parts).astype(int)
        numbers = {
            "index": np.array(indices)[places],
            "warnings": _joined(
                together.warnings(
                    {n: column[part.places] for n, column in columns.items()},
                    part.answers,
                    part.points,
                )
                for part in parts
            ),
            "steps": _joined(part.answers.steps for part in parts),
        }
        metrics = {n: _joined((part.values | part.stated)[n] for part in parts) for n in about}
        wall = np.full(places.size, (time.perf_counter() - began) / len(indices))
        numbers |= {"wall": wall, "loop": wall}
        provenance = self.about | {"text": text, "lanes": together.group.width}
        return Block([""] * places.size, numbers, metrics, about, provenance)

    def _parts(self, together: Together, columns: dict[str, np.ndarray]) -> Iterator[Reached]:
        """Points that are sound, as they end."""
        summing = together.summing
        if summing.request is not None:
            yield from Ladder(together, columns).climb()
            return
        points = together.points(columns)
        answers = together.answers(points)
        good, values = summing.sound(answers, points), summing.metrics(answers, points)
        stated = together.errors(columns, answers) if summing.stated else {}
        if stated:
            good &= summing.stated_alike(values, stated)
        yield Reached(np.arange(good.size), points, answers, values, stated).at(good)


def check_width() -> None:
    """Raises ValueError where CLEARANCE_LANES is no number of lanes."""
    if not off():
        chosen_width()
