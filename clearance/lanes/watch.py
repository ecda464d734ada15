"""Outputs of the lanes: extremes located on the dense output, sums over steps and over samples.

The search is that of stepping/locating.py. A step is searched where its ends and the end before
allow a larger value inside, at places that the driver gives. Such places, and samples, of one run
are looked at several at a time, one in each lane.
"""

from collections.abc import Callable
from dataclasses import dataclass
from operator import add

import numpy as np

from clearance.lanes.rows import Piece, Rows
from clearance.stepping import control
from clearance.tracing.emission import Program, kernel_text

#: 45 times the share of a sum that Simpson's rule may err by in a step: at most, and over rtol^1.5,
#: for a tighter run has more steps
ROUGH, FINE = 45.0 * 3e-8, 45.0 * 30.0


@dataclass(frozen=True)
class Quantity:
    """A quantity whose largest value times its sign is located.

    channel: its place among the outputs that lanes compute; paired: length of the vector of this
        one and the next;
    always: also before the window; searched: inside steps too, not only where they end.
    """

    channel: int
    paired: bool
    sign: float
    always: bool = False
    searched: bool = True


@dataclass(frozen=True)
class Reduction:
    """Mean over time of samples, or their largest value.

    value(piece, outputs, ideal, numbers): traced, from outputs, ideal motions at the sample, and
    the point's numbers. stepped: the mean is over the steps, see `integrate`; nothing is given.
    timed: so is it, and the value a flag, 0 or 1.
    """

    value: Callable
    mean: bool = True
    stepped: bool = False
    timed: bool = False

    def of_turns(self, totals: np.ndarray, length: np.ndarray) -> np.ndarray:
        """The number of the window from what lanes keep at the end of its turns (runs, turns);
        length: of the window [s].
        """
        if self.stepped:
            return totals[:, -1] / length
        return totals.sum(axis=1) if self.mean else totals.max(axis=1)


@dataclass(frozen=True)
class Watch:
    """Outputs that are stored of a run.

    quantities: see above; reductions: sums over samples or steps; tracks: outputs stored at every
        sample; ideal: how many numbers of each sample the reductions have.
    """

    quantities: tuple[Quantity, ...]
    reductions: tuple[Reduction, ...]
    tracks: tuple[int, ...]
    ideal: int
    numbers: int = 0


def text_of(watch, count: int) -> str:
    """All that the pieces take from a watch of so many outputs: its numbers, and the formulas of
    its reductions.
    """
    piece = Piece(Rows(), None)
    counts = {"row": count, "ideal": watch.ideal, "numbers": watch.numbers}
    inputs = [[piece.trace.load(f"{n}[{i}]") for i in range(k)] for n, k in counts.items()]
    sums = {k: r.value(piece, *inputs) for k, r in enumerate(watch.reductions)}
    kinds = [(r.mean, r.stepped, r.timed) for r in watch.reductions]
    about = watch.quantities, kinds, watch.tracks, counts
    return f"{about} {kernel_text(Program('sums', sums, {}), {})}"


def add_rows(rows, watch, held: tuple[str, ...]) -> None:
    """Rows of the outputs; held: rows of a step that places inside it need."""
    count = len(watch.quantities)
    rows.add("refine interval within found share sample_time sample_theta")
    rows.add("inner_time inner_theta")
    for name in held:
        rows.add(f"sample_{name}", count=rows.counts[name])
    rows.add("value last next between search seen", count=count)
    rows.add("sums summands at_begin at_middle at_end", count=len(watch.reductions))
    rows.add("tracks", count=len(watch.tracks))
    rows.add("ideal", count=watch.ideal)
    rows.add("numbers", count=watch.numbers)


def values_of(piece, watch, row: list) -> list:
    """Values of the quantities, of vectors their squares, times their signs."""
    values = []
    for q in watch.quantities:
        value = row[q.channel]
        if q.paired:
            value = value * value + row[q.channel + 1] * row[q.channel + 1]
        values.append(value * q.sign)
    return values


def look(piece, shape, entries, watch, now, y: list, polynomial: list, taken) -> None:
    """Take in the end of a step, where it is taken: its time and state. Find the quantities that
    may have an extreme inside it. polynomial: its dense output.
    """
    width, back, n = piece["h"], piece["interval"], shape.states
    moved = [piece.choose(taken, v, 0.0) for v in piece.along(polynomial, 0.5, n)]
    middle = [*map(add, piece.all("y"), moved), *y[n:]]
    early = piece.none(back > 0.0)
    per_width = 1.0 / piece.largest(width, 1e-300)
    per_back = 1.0 / piece.largest(back, 1e-300)
    curving = width * 4.0 / piece.largest(width + back, 1e-300)
    row = piece.call(entries.outputs, now, y)
    inner = piece.call(entries.outputs, piece["t"] + 0.5 * width, middle)
    flags = [False]
    values = zip(values_of(piece, watch, row), values_of(piece, watch, inner), strict=True)
    for k, (q, (value, between)) in enumerate(zip(watch.quantities, values, strict=True)):
        before, last, earlier = (
            piece.at("value", k),
            piece.at("next", k),
            piece.at("last", k),
        )
        best = piece.largest(before, value)
        slope, back_slope = (value - last) * per_width, (last - earlier) * per_back
        chords = last, value, best, slope, per_width, back_slope, curving
        (peaks,) = piece.formula(control.may_peak, *chords)
        bends = peaks > 0.5
        rises = piece.largest(last, value) + abs(value - last) > best
        may = taken & ((early & rises) | bends)
        if not q.always:
            may &= piece["within"] > 0.5
        if q.searched:
            flags.append(may)
            best = piece.largest(best, between)
            piece.set_at(k, between=between)
        piece.set_at(
            k,
            value=piece.choose(taken, best, before),
            last=piece.choose(taken, last, earlier),
            next=piece.choose(taken, value, last),
            search=piece.flag(may) if q.searched else 0.0,
        )
    integrate(piece, watch, taken, row, inner)
    piece.keep(taken, interval=width)
    piece.set(found=piece.flag(piece.either(*flags)))


def integrate(piece, watch, taken, row: list, inner: list) -> None:
    """Add a step to the sums over steps by Simpson's rule, or leave it to the driver.

    The error of this rule for a cosine of size A, whose middle is c away from its chord, is
    c^2 / (45 A).
    """
    width = piece["h"]
    within = taken & (piece["within"] > 0.5)
    middles = (value for _, value in stepped(piece, watch, inner))
    panels, rough = {}, [piece.none(within)]
    rtol = piece["rtol"]
    share = piece.smallest(ROUGH, FINE * rtol * piece.sqrt(rtol))
    for (k, value), middle in zip(stepped(piece, watch, row), middles, strict=True):
        before, total = piece.at("at_end", k), piece.at("sums", k)
        panels[k] = panel = width * ((before + 4.0 * middle + value) * (1.0 / 6.0))
        bend = middle - 0.5 * (before + value)
        size = piece.largest(before, middle, value)
        rough.append(width * bend * bend > share * size * (total + panel))
        piece.set_at(
            k, at_begin=before, at_middle=middle, at_end=piece.choose(taken, value, before)
        )
    rough = piece.either(*rough)
    for k, panel in panels.items():
        piece.set_at(k, sums=piece.at("sums", k) + piece.choose(rough, 0.0, panel))
    piece.set(refine=piece.flag(within & rough))


def stepped(piece, watch, row: list) -> list[tuple[int, object]]:
    """Places and values of the reductions over steps."""
    reductions = enumerate(watch.reductions)
    return [(k, r.value(piece, row, [], [])) for k, r in reductions if r.stepped]


def look_first(piece, entries, watch) -> None:
    """Take in the outputs where a phase begins."""
    row = piece.call(entries.outputs, piece["t"], piece.all("y"))
    values = values_of(piece, watch, row)
    piece.set(next=values, value=map(piece.largest, values, piece.all("value")))
    piece.set(interval=0.0, found=0.0, refine=0.0)
    for k, value in stepped(piece, watch, row):
        piece.set_at(k, at_end=value)


def _placed(rows, shape, entries, settled: Callable, name: str, *of: str) -> tuple:
    """Time and state at places inside a step; of: see the `settled` of a method."""
    piece = Piece(rows, None)
    time = piece[f"{name}_time"]
    y = settled(piece, shape, entries, piece[f"{name}_theta"], time, *of)
    return piece, time, y + piece.all("y")[shape.states :]


def inside(rows, shape, entries, watch, settled: Callable) -> Piece:
    """Quantities at places inside a step of one run, one in each lane."""
    piece, time, y = _placed(rows, shape, entries, settled, "inner")
    row = piece.call(entries.outputs, time, y)
    piece.set(seen=values_of(piece, watch, row))
    for k, value in stepped(piece, watch, row):
        piece.set_at(k, summands=value)
    return piece


def sample(rows, shape, entries, watch, settled: Callable) -> Piece:
    """Outputs at samples of one run, one in each lane: sums over samples, and what is tracked."""
    piece, time, y = _placed(rows, shape, entries, settled, "sample", "sample_")
    row = piece.call(entries.samples, time, y)
    ideal, mine, share = piece.all("ideal"), piece.all("numbers"), piece["share"]
    for k, reduction in enumerate(watch.reductions):
        if reduction.stepped:
            continue
        value, before = reduction.value(piece, row, ideal, mine), piece.at("sums", k)
        after = before + share * value
        if not reduction.mean:
            larger = piece.largest(before, value)
            after = piece.choose(share > 0.0, larger, before)
        piece.set_at(k, sums=after)
    piece.set(tracks=[row[c] for c in watch.tracks])
    return piece
