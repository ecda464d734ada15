"""Points of a sweep in lanes with the errors that are requested of them: the ladder of
accuracy/request.py, point by point, all points side by side.

The ordinary way gives the reason of a point that fails on the way, that does not reach its errors
at 1e-10, or whose film table alone makes larger ones.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase

import numpy as np

from clearance.accuracy.companion import (
    ALIKE,
    LONGER,
    LOOSER,
    LOOSEST,
    SAFETY,
    THROUGHOUT,
    differences,
    spreads,
)
from clearance.accuracy.request import (
    AIM,
    FIRST,
    LARGEST_STEP,
    LOST,
    LOST_STEP,
    PARTED,
    PRINTED,
    TIGHTEST,
    Request,
)
from clearance.lanes.group import Answers, Points
from clearance.results.errors import TRAJECTORY, Error, Errors
from clearance.values.algebra import Arrays
from clearance.values.spelling import alike


@dataclass(frozen=True)
class Compared:
    """Numbers of some points that are compared, a row each: by name their values.

    tracks: offsets in clearances over their sizes, (points, offsets, samples).
    """

    good: np.ndarray
    steps: np.ndarray
    tracks: np.ndarray
    numbers: Arrays

    def at(self, rows: np.ndarray) -> "Compared":
        """Some of the points."""
        arrays = [getattr(self, f.name)[rows] for f in fields(self)[:-1]]
        return Compared(*arrays, {n: values[rows] for n, values in self.numbers.items()})

    def taking(self, rows: np.ndarray, others: "Compared") -> "Compared":
        """The same with others in place of some points."""
        result = self.at(np.arange(len(self.good)))
        for f in fields(self)[:-1]:
            getattr(result, f.name)[rows] = getattr(others, f.name)
        for name, values in result.numbers.items():
            values[rows] = others.numbers[name]
        return result


@dataclass(frozen=True)
class Reached:
    """Points that have their errors: places in the block, numbers, answers, metrics, and stated
    errors by name.
    """

    places: np.ndarray
    points: Points
    answers: Answers
    values: Arrays
    stated: Arrays

    def at(self, rows: np.ndarray) -> "Reached":
        """Some of the points."""
        if rows.all():
            return self
        parts = self.points.at(rows), self.answers.at(rows)
        numbers = ({n: v[rows] for n, v in d.items()} for d in (self.values, self.stated))
        return Reached(self.places[rows], *parts, *numbers)


class Ladder:
    """The tolerances of the points of a block; together: their group; columns: their values."""

    def __init__(self, together, columns: Arrays):
        self.together, self.columns = together, columns
        self.summing = together.summing
        self.request: Request = self.summing.request
        self.names = [n.removesuffix("_error") for n in self.summing.stated]
        self.named = {alike(name, self.names) for name in self.request.asked}
        #: those that a request may be about
        self.asked = [
            n for n in self.names if n in self.named or any(fnmatchcase(n, p) for p in PRINTED)
        ]

    def climb(self) -> Iterator[Reached]:
        """Points as they reach their errors; those that do not are left out."""
        count = len(next(iter(self.columns.values())))
        places, first = np.arange(count), max(min(*self.request.asked.values(), FIRST), TIGHTEST)
        rtol, loose_rtol = np.full(count, first), np.full(count, min(LOOSER * first, LOOSEST))
        *_, loose = self._ran(places, loose_rtol)
        films = self._film_errors(places, loose, loose_rtol) if self.request.films else {}
        film_rtol = loose_rtol.copy()
        while places.size:
            points, answers, tight = self._ran(places, rtol)
            stated, apart = self._stated(places, tight, loose, rtol, loose_rtol)
            worst, table = self._over(tight, stated, films, apart)
            again = (worst <= np.maximum(table, 1.0)) & (loose_rtol < film_rtol)
            if films and again.any():  # at the tolerance of the last companion
                closer = self._film_errors(places[again], loose.at(again), loose_rtol[again])
                for name, errors in films.items():
                    errors[again] = closer[name]
                film_rtol[again] = loose_rtol[again]
                worst, table = self._over(tight, stated, films, apart)
            values = {n: tight.numbers[n] for n in self.summing.first}
            errors = {f"{n}_error": stated[n] + films.get(n, 0.0) for n in self.names}
            good = tight.good & loose.good & self.summing.stated_alike(values, errors)
            ended = good & (worst <= 1.0) & (table <= 1.0)
            yield Reached(places, points, answers, values, errors).at(ended)
            fall = np.maximum(LARGEST_STEP, AIM / np.maximum(worst, 1.0))
            fall = np.where(apart > PARTED, LOST_STEP, fall)
            stays = good & (worst > np.maximum(table, 1.0)) & (rtol * fall >= LOST)
            places, loose, loose_rtol = places[stays], tight.at(stays), rtol[stays]
            rtol, film_rtol = (rtol * fall)[stays], film_rtol[stays]
            films = {n: errors[stays] for n, errors in films.items()}

    def _ran(
        self, places: np.ndarray, rtol: np.ndarray, longer: float = 1.0, strong: tuple = ()
    ) -> tuple[Points, Answers, Compared]:
        """Some points at their tolerances; strong: tables that are stronger."""
        columns = {n: v[places] for n, v in self.columns.items()}
        points = self.together.points(columns, rtol, *strong)
        points.longest *= longer
        answers = self.together.answers(points)
        good, numbers = self.summing.sound(answers, points), self.summing.metrics(answers, points)
        numbers = numbers | self.summing.located_in(answers, points)
        sizes = self.summing.sizes(points)
        tracks = answers.tracks[:, self.summing.offsets] / sizes[..., None]
        return points, answers, Compared(good, answers.steps, tracks, numbers)

    def _stated(
        self,
        places: np.ndarray,
        tight: Compared,
        loose: Compared,
        rtol: np.ndarray,
        loose_rtol: np.ndarray,
    ) -> tuple[Arrays, np.ndarray]:
        """Errors of integration by name, and the stated error of the trajectory."""
        same = np.abs(loose.steps - tight.steps) <= ALIKE * tight.steps
        if same.any():
            *_, longer = self._ran(places[same], loose_rtol[same], LONGER)
            loose = loose.taking(same, longer)
        trajectory = THROUGHOUT * np.abs(tight.tracks - loose.tracks).max(axis=(1, 2))
        farther = (loose_rtol / rtol - 1.0) / (LOOSER - 1.0)
        share = np.where(trajectory > PARTED, 1.0, farther)
        numbers = {n: np.stack([v, *[loose.numbers[n]] * 2]) for n, v in tight.numbers.items()}
        by = differences(numbers, spreads(numbers), 1.0)
        stated = {n: SAFETY / share * error for n, (error, _) in by.items()}
        return stated, trajectory / share

    def _film_errors(self, places: np.ndarray, plain: Compared, rtol: np.ndarray) -> Arrays:
        """Errors of film tables by name; none where there are no tables."""
        columns = {n: v[places] for n, v in self.columns.items()}
        if not (strong := self.together.stronger(columns)):
            return {}
        times, tables = strong
        *_, strong = self._ran(places, rtol, strong=(tables,))
        with np.errstate(invalid="ignore"):  # periods that are endless
            return {n: np.abs(strong.numbers[n] - v) / times for n, v in plain.numbers.items()}

    def _over(
        self,
        tight: Compared,
        stated: Arrays,
        films: Arrays,
        trajectory: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """The worst of stated over requested errors of each point, and of those of film tables."""
        worst, table = np.zeros((2, len(trajectory)))
        none = np.zeros_like(trajectory)
        triples = {n: (tight.numbers[n], stated[n], films.get(n, none)) for n in self.asked}
        errors = {n: np.column_stack(triple) for n, triple in triples.items()}
        for i, apart in enumerate(trajectory.tolist()):
            numbers = ((n, *row[i].tolist()) for n, row in errors.items())
            rows = {
                n: Error(value, error, film=film)
                for n, value, error, film in numbers
                if n in self.named or not math.isnan(value)  # of more turns than the point has
            }
            rows[TRAJECTORY] = Error(0.0, apart)
            (worst[i], _), (table[i], _) = self.request.over(Errors(rows))
        return worst, table
