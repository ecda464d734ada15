"""The tests as on other processors, by what can be set on this one:

    python tests/benchmarks/processors.py [--quick] [--minutes 15] [--settings NAME,...] [PATH ...]

runs README's tests under each setting, a file on each core at a time, and prints a table. Machine
code, OpenBLAS, numpy's loops and the C library have a setting each; two set them all, as a
processor with AVX2 and one with SSE2 would. PATH: tests to run in place of all. --quick: the few
settings that bring what the others do; other numbers of lanes for files that name sweeps, scatters
or lanes. Files near last bits come first, the others are shuffled; settings take turns.
--minutes: all ends when they are over, also within a file. --journal: a file of what ended, which
another call goes on from. --update puts the table into tests/benchmarks/README.md. The exit status
is 1 where a test failed.
"""

import itertools
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))

from tests.benchmarks.publishing import RESULTS, options, put  # noqa: E402

BEGIN = "<!-- processors -->"
WIDE = ("avx512", "avx10", "amx")  # LLVM's names of what no processor of 2013 has
FUSING = ("avx", "fma", "f16c", "bmi", "amx", "vaes", "vpclmul", "gfni", "xop")
LATER = ("sse3", "sse4", "ssse3", "popcnt", "crc32", "movbe", "lzcnt", "pclmul", "aes", "sha")
#: files whose numbers are near last bits
NEAR = (
    "tests/motions/test_chaos.py",
    "tests/mechanism/test_dead_centre.py",
    "tests/tracing/test_elementary.py",
    "tests/stepping/test_tableaus.py",
    "tests/mechanism/test_assembly.py",
    "tests/lanes/test_lanes.py",
    "tests/sweeping/test_together.py",
    "tests/regression/test_regression.py",
    "tests/paper_figures/test_figures.py",
)
#: settings that bring what the others do, for a shorter matrix
FEW = ("AVX2", "SSE2", "one lane", "eight lanes")
OF_LANES = re.compile("sweep|scatter|lanes")
PYTEST = ("-v", "--tb=short", "-p", "no:cacheprovider")
ENDED = re.compile(r"^(\S+?::.+?) (PASSED|FAILED|ERROR|SKIPPED)\b", re.MULTILINE)


def without(*begins: str) -> str:
    """LLVM's features of this processor, those that begin so switched off."""
    there = llvm.get_host_cpu_features()
    return ",".join(
        f"{'+' if on and not name.startswith(begins) else '-'}{name}"
        for name, on in sorted(there.items())
    )


def numpy_loops(*begins: str) -> str:
    """Numpy's names of the loops that this processor has, of those that begin so; also of those
    that are switched off already.
    """
    there = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    off = os.environ.get("NPY_DISABLE_CPU_FEATURES", "").split()
    return " ".join(name for name in dict.fromkeys([*there, *off]) if name.startswith(begins))


def settings() -> dict[str, dict[str, str]]:
    """Environment of each setting."""
    avx2 = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": without(*WIDE)}
    sse2 = {"NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": without(*FUSING, *LATER)}
    no_wide_loops = {"NPY_DISABLE_CPU_FEATURES": numpy_loops("AVX512", "X86_V4")}
    no_loops = {"NPY_DISABLE_CPU_FEATURES": numpy_loops("")}
    narrow = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW"}
    plain = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-FMA4,-AVX"}
    kernels = ["Haswell", "Zen", "Sandybridge", "Nehalem", "Prescott"]
    if llvm.get_host_cpu_features().get("avx512vl"):  # else these instructions are illegal
        kernels.append("SkylakeX")
    return {
        "this processor": {},
        "AVX2": avx2 | no_wide_loops | narrow | {"OPENBLAS_CORETYPE": "Haswell"},
        "SSE2": sse2 | no_loops | plain | {"OPENBLAS_CORETYPE": "Prescott"},
        "libraries of AVX2": no_wide_loops | narrow | {"OPENBLAS_CORETYPE": "Haswell"},
        **{f"OpenBLAS {name}": {"OPENBLAS_CORETYPE": name} for name in kernels},
        "numpy without AVX-512": no_wide_loops,
        "numpy without loops": no_loops,
        "C library without AVX-512": narrow,
        "C library without FMA": plain,
        "code without AVX-512": avx2,
        "one lane": {"CLEARANCE_LANES": "1"},
        "eight lanes": {"CLEARANCE_LANES": "8"},
    }


def environment(setting: dict[str, str], store: str | Path) -> dict[str, str]:
    """That of a process with a store of its own, unless the number of lanes alone is set: tables of
    films are made with other last bits.
    """
    apart = {"CLEARANCE_STORE": str(store)} if set(setting) - {"CLEARANCE_LANES"} else {}
    return os.environ | apart | setting


@dataclass
class Outcome:
    """Tests of a file under a setting by their ends; those of a file that was cut had ended."""

    setting: str
    path: str
    ends: Counter = field(default_factory=Counter)
    failed: list[str] = field(default_factory=list)
    cut: bool = False

    def take(self, printed: str, status: int) -> None:
        """Read them from the output of pytest; status: that it ended with."""
        lines = ENDED.findall(printed)
        self.ends = Counter(end.lower() for _, end in lines)
        self.failed = [test for test, end in lines if end in ("FAILED", "ERROR")]
        if not (self.cut or self.failed) and status not in (0, 5):
            self.failed = [f"{self.path}: exit status {status}"]

    def line(self) -> str:
        counts = ", ".join(f"{n} {end}" for end, n in self.ends.items())
        return f"{self.path}: {counts or 'no test'}{', then cut' if self.cut else ''}"


class Matrix:
    """Runs of files under settings, until the time is over.

    folder: that of the stores; journal: a file that takes a line for each run.
    """

    def __init__(self, folder: str, minutes: float, journal: str | None):
        self.folder, self.end = Path(folder), time.monotonic() + 60.0 * minutes
        self.journal, self.settings = journal or os.devnull, settings()
        self.outcomes = kept(journal)
        self.running: set[subprocess.Popen] = set()

    def run(self, jobs: Iterable[tuple[str, str]], workers: int) -> None:
        """Files and settings, as far as the journal does not have them."""
        done = {(o.path, o.setting) for o in self.outcomes}
        jobs = [job for job in jobs if job not in done]
        with ThreadPoolExecutor(workers) as pool:
            try:
                for _ in pool.map(self._take, jobs):
                    pass
            finally:
                self.end = -math.inf
                for process in list(self.running):
                    stopped(process)

    def _take(self, job: tuple[str, str]) -> None:
        """Run a file under a setting, unless the time is over."""
        if time.monotonic() > self.end:
            return
        outcome, printed = self._outcome(*job)
        self.outcomes.append(outcome)
        with open(self.journal, "a") as journal:
            journal.write(json.dumps(vars(outcome)) + "\n")
        complaints = f"\n{printed[-5000:]}" if outcome.failed else ""
        print(f"{outcome.setting}: {outcome.line()}{complaints}", file=sys.stderr, flush=True)

    def _outcome(self, path: str, name: str) -> tuple[Outcome, str]:
        """Tests of a file by their ends, and what pytest printed."""
        outcome = Outcome(name, path)
        with tempfile.TemporaryFile("w+") as file, tempfile.TemporaryDirectory() as apart:
            # one folder for all has pytest read it while another process removes from it
            process = subprocess.Popen(
                [sys.executable, "-m", "pytest", *PYTEST, f"--basetemp={apart}/tests", path],
                cwd=ROOT,
                env=environment(self.settings[name], self.folder / name),
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            self.running.add(process)
            try:
                process.wait(None if math.isinf(self.end) else max(self.end - time.monotonic(), 0))
            except subprocess.TimeoutExpired:
                outcome.cut = True
                stopped(process)
            self.running.discard(process)
            file.seek(0)
            outcome.take(printed := file.read(), process.returncode)
        return outcome, printed


def stopped(process: subprocess.Popen) -> None:
    """A process is killed with its session."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def files(rng: random.Random) -> list[str]:
    """All files of tests: those near last bits, then the others shuffled."""
    there = [str(p.relative_to(ROOT)) for p in sorted((ROOT / "tests").rglob("test_*.py"))]
    others = [path for path in there if path not in NEAR]
    return [*NEAR, *rng.sample(others, len(others))]


def concerned(path: str, setting: dict[str, str]) -> bool:
    """True where a setting changes what a file tests."""
    text = (ROOT / path).read_text() if (ROOT / path).is_file() else "lanes"
    return set(setting) != {"CLEARANCE_LANES"} or bool(OF_LANES.search(text))


def kept(journal: str | None) -> list[Outcome]:
    """Outcomes of a journal: of files that came to their end without a failure."""
    if journal is None or not Path(journal).exists():
        return []
    outcomes = [Outcome(**json.loads(line)) for line in Path(journal).read_text().splitlines()]
    return [o for o in outcomes if not (o.cut or o.failed)]


def table(outcomes: list[Outcome], names: list[str]) -> list[str]:
    """Tests of each setting by their ends."""
    heads = ["setting", "files", "of them cut", "passed", "skipped", "failed"]
    rows = [heads, ["---"] * len(heads)]
    for name in names:
        runs = [o for o in outcomes if o.setting == name]
        ends = sum((Counter(o.ends) for o in runs), Counter())
        cut, failed = sum(o.cut for o in runs), sum(len(o.failed) for o in runs)
        rows.append([name, len(runs), cut, ends["passed"], ends["skipped"], failed])
    return [f"| {' | '.join(map(str, row))} |" for row in rows]


def main() -> int:
    chosen = options(
        __doc__,
        paths=([], "files of tests (all)"),
        quick=(False, f"only {', '.join(FEW)}"),
        minutes=(math.inf, "until the end"),
        settings=(str, "names, with commas between"),
        workers=(os.cpu_count(), "processes"),
        seed=(time.time_ns() % 1000, "of the order"),
        journal=(str, "file to go on from"),
    )
    names = [*(FEW if chosen.quick else settings())]
    if chosen.settings:
        names = chosen.settings.split(",")
    if unknown := set(names) - set(settings()):
        raise SystemExit(f"settings are {', '.join(settings())}; got {', '.join(sorted(unknown))}")
    print(f"--seed {chosen.seed}", file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        matrix = Matrix(folder, chosen.minutes, chosen.journal)
        paths = chosen.paths or files(random.Random(chosen.seed))
        jobs = itertools.product(paths, names)
        if chosen.quick:
            jobs = [(path, n) for path, n in jobs if concerned(path, matrix.settings[n])]
        matrix.run(jobs, chosen.workers)
    lines = table(matrix.outcomes, names)
    bad = [f"{o.setting}: {test}" for o in matrix.outcomes for test in o.failed]
    print("\n".join([*lines, "", *bad]))
    if chosen.update:
        put(RESULTS, lines, BEGIN)
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
