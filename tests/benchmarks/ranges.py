"""Random scenes against relations that must hold: `python tests/benchmarks/ranges.py --minutes 30`.

Each seed makes a scene of tests/random_scenes.py, runs it, holds its outputs against Newton's
equations and its energy, and tries one relation or command: the scene turned, moved, mirrored, in
other units, renamed, reordered, with a body split, from a file, restarted, in a sweep, with other
samples or another method. The table counts by capability:

    completed   the run came to its end, and all that was tried agreed
    refused     one line says what is wrong with the scene, before anything runs
    ended       the run ended part-way; time, place and reason are named
    failed      another error, a reason without a name, or more than two minutes of CPU
    wrong       a relation or a number is off by more than the errors of integration may grow to

`--seed N` runs one scene and prints it. `--scenes N` runs so many, `--first N` from that seed on.
With `--log FILE` outcomes stay: the same call goes on after the last one, several at a time share
the file, and the table is of all its seeds. `--again` repeats its scenes that failed or were wrong.
`--update` puts the table into tests/benchmarks/README.md; `--scenes 0` runs nothing before.
"""

import contextlib
import json
import logging
import math
import random
import signal
import sys
import time
import traceback
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

import clearance as cl  # noqa: E402
from clearance.accuracy.horizon import NotSolved  # noqa: E402
from tests.benchmarks import publishing  # noqa: E402
from tests.random_scenes import ALIKE, draw  # noqa: E402
from tests.trials import DEAR, TRIALS, Base, Wrong, independent, run  # noqa: E402

BEGIN = "<!-- ranges -->"
KINDS = ("completed", "refused", "ended", "failed", "wrong")
UNWANTED = ("failed", "wrong")
BUDGET = 120.0  # seconds of CPU of a scene
#: reasons without a name
UNNAMED = ("a loop cannot close beyond this position, or a law", "fell below what the clock",
           "changed its branch or rtol", "rtol is too loose for")  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """End of a scene: one of KINDS, and the reason."""

    seed: int
    kind: str
    reason: str
    tags: tuple[str, ...]
    seconds: float = 0.0


# --- one scene
class TooLong(KeyboardInterrupt):
    """The time of a scene is over; another error would only fail the solution of a film."""


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Without warnings of runs and lines of logs, in any process."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cl.RunWarning)
        logging.disable(logging.CRITICAL)
        try:
            yield
        finally:
            logging.disable(logging.NOTSET)


@quiet()
def examined(seed: int) -> Outcome:
    """The outcome of a scene, within the budget of time."""
    began, tags = time.process_time(), ["all scenes"]

    def late(*_):
        raise TooLong(f"more than {BUDGET:g} s")

    previous = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, BUDGET)
    try:
        kind, reason = _tried(seed, tags)
    except (Exception, TooLong) as error:
        kind, reason = judged(error)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, previous)
    return Outcome(seed, kind, reason, tuple(tags), time.process_time() - began)


def _tried(seed: int, tags: list[str]) -> tuple[str, str]:
    """The scene of a seed, its numbers, and one relation."""
    drawn = draw(seed)
    tags += drawn.tags
    base = Base(drawn.scene, drawn.span, run(drawn.scene, drawn.span))
    independent(drawn.scene, base.run)
    for name in order(seed):
        tags.append(f"relation {name}")
        if TRIALS[name](drawn, base, random.Random(f"{name} {_of(name, seed)}")):
            return "completed", name
        tags.pop()
    return "completed", "no relation"


def order(seed: int) -> list[str]:
    """All trials, at random; by their shares and alike for scenes of the same parts where dear."""
    late = {n: -math.log(random.Random(f"order {n} {_of(n, seed)}").random()) for n in TRIALS}
    return sorted(TRIALS, key=lambda name: late[name] / DEAR.get(name, 1.0))


def _of(name: str, seed: int) -> int:
    """The number of which a trial is drawn."""
    return seed // ALIKE if name in DEAR else seed


def judged(error: BaseException) -> tuple[str, str]:
    """Kind of an outcome that ended in an error, and its reason in one line."""
    text = str(error).strip()
    if isinstance(error, Wrong):
        return "wrong", text
    if isinstance(error, cl.SimulationError | NotSolved):
        named = not any(words in text for words in UNNAMED)
        return ("ended" if named else "failed"), text
    if isinstance(error, ValueError | TypeError) and _raised_on_purpose(error):
        return "refused", text
    return "failed", "".join(traceback.format_exception(error, limit=-3))


def _raised_on_purpose(error: BaseException) -> bool:
    """True for an error that a line `raise` of the package made, in one line."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    package = "/clearance/" in last.filename and (last.line or "").startswith("raise")
    return package and "\n" not in str(error)


# --- the table
def table(outcomes: Iterable[Outcome]) -> list[str]:
    """Counts by capability, as lines of Markdown, and the number of scenes."""
    counts: dict[str, Counter] = defaultdict(Counter)
    for outcome in outcomes:
        for tag in outcome.tags:
            counts[tag][outcome.kind] += 1
    head = f"| | {' | '.join(KINDS)} |", f"|---{'|---' * len(KINDS)}|"
    order = sorted(counts, key=lambda tag: (tag != "all scenes", tag))
    rows = [f"| {t} | {' | '.join(str(counts[t][k]) for k in KINDS)} |" for t in order]
    return [*head, *rows, "", summary(outcomes)]


def summary(outcomes: Iterable[Outcome]) -> str:
    """Number of scenes, and what they cost."""
    seeds, seconds = [o.seed for o in outcomes], [o.seconds for o in outcomes]
    mean = f"{sum(seconds) / len(seconds):.2g} s of CPU each" if seconds else "none"
    return f"{len(seeds)} scenes, seeds {min(seeds)} to {max(seeds)}: {mean}."


def outcomes_of(seeds: Iterator[int], workers: int, end: float) -> Iterator[Outcome]:
    """Outcomes of seeds, until a time."""
    if workers == 1:
        for seed in seeds:
            if time.monotonic() > end:
                return
            yield examined(seed)
        return
    with ProcessPoolExecutor(workers) as pool:
        while time.monotonic() < end:
            block = [s for _, s in zip(range(8 * workers), seeds, strict=False)]
            if not block:
                return
            yield from pool.map(examined, block, chunksize=ALIKE)


OPTIONS = {
    "minutes": (30.0, "of all scenes together (30)"),
    "scenes": (int, "so many scenes, however long they take"),
    "first": (0, "the first seed (0)"),
    "seed": (int, "this scene alone"),
    "workers": (1, "processes"),
    "log": (Path, "a file of outcomes, to which this call adds"),
    "again": (False, "its scenes that were not right"),
}


def logged(path: Path | None) -> dict[int, Outcome]:
    """Outcomes of a file by seed; the last of a seed counts."""
    if path is None or not path.exists():
        return {}
    return {(o := Outcome(**json.loads(line))).seed: o for line in path.open()}


def seeds_of(options, done: dict[int, Outcome]) -> Iterator[int]:
    """Seeds to run: the requested ones that the log does not have yet."""
    if options.seed is not None:
        return iter([options.seed])
    if options.again:
        return (seed for seed, o in sorted(done.items()) if o.kind in UNWANTED)
    count = 10**9 if options.scenes is None else options.scenes
    return (s for s in range(options.first, options.first + count) if s not in done)


def main(arguments: list[str] | None = None) -> int:
    """Try scenes, print what failed, then the table."""
    options = publishing.options("random scenes against relations", arguments, **OPTIONS)
    done = logged(options.log)
    end = time.monotonic() + (60.0 * options.minutes if options.scenes is None else 1e9)
    for outcome in outcomes_of(seeds_of(options, dict(done)), options.workers, end):
        done[outcome.seed] = outcome
        if outcome.kind in UNWANTED or options.seed is not None:
            print(f"--seed {outcome.seed}: {outcome.kind}: {outcome.reason}", flush=True)
        if options.log:
            with options.log.open("a") as log:
                print(json.dumps(vars(outcome)), file=log)
    lines = table(done.values())
    print("\n".join(lines))
    if options.update:
        publishing.put(publishing.RESULTS, lines, BEGIN)
    return int(any(o.kind in UNWANTED for o in done.values()))


if __name__ == "__main__":
    sys.exit(main())
