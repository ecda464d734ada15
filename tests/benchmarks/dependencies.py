"""Oldest and newest dependencies: `python tests/benchmarks/dependencies.py [--update]`.

For each Python of the classifiers that is on this machine: the lowest and the highest versions of
the core dependencies that pyproject.toml allows and that have a wheel for it go into a virtual
environment that is thrown away. There README's first `clearance run` and the tests TESTS run. The
exit status is 1 where something failed. --python: interpreters in place of those on the path and
of pyenv. --sets: one of the two.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import Version
from publishing import publish, require

ROOT = Path(__file__).resolve().parent.parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
CORE = [Requirement(line) for line in PROJECT["dependencies"]]
MARK = "<!-- dependencies -->"
#: of the extra test; the others serve tests that are not among those below
TOOLS = ("pytest", "hypothesis", "xarray", "h5netcdf", "pandas")
#: results, checksums, scenes, kernels, motions with known solutions, sweeps, pictures
TESTS = (
    "tests/results/test_results.py",
    "tests/files/test_checksums.py",
    "tests/scene/test_scene.py",
    "tests/mechanism/test_kernels.py",
    "tests/tracing/test_elementary.py",
    "tests/sweeping/test_points.py",
    "tests/sweeping/test_resumed.py",
    "tests/commands/test_plot_command.py",
)
#: lowest: oldest releases call newer ones below them in ways that these no longer like
WARNINGS = {"lowest": ["-W", "ignore::DeprecationWarning"], "highest": []}
COUNTED = re.compile(r"(\d+) (passed|failed|error)")


class Failure(Exception):
    """A command that failed; its last lines."""


def output(*command: str | Path, **options) -> str:
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode:
        raise Failure("\n".join((done.stdout + done.stderr).strip().splitlines()[-12:]))
    return done.stdout


def supported() -> list[str]:
    """Versions of Python with a classifier."""
    head = "Programming Language :: Python :: "
    return [c.removeprefix(head) for c in PROJECT["classifiers"] if c.startswith(head)]


def version(python: str | Path) -> str | None:
    """Minor version of an interpreter; none where it does not start."""
    try:
        return output(python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])").strip()
    except (Failure, OSError):
        return None


def interpreters() -> dict[str, str | Path]:
    """One of each supported Python: this one, one on the path or one of pyenv."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    there = {}
    for wanted in supported():
        name = f"python{wanted}"
        candidates = [sys.executable, shutil.which(name), *pyenv.glob(f"{wanted}.*/bin/{name}")]
        usable = [python for python in candidates if python and version(python) == wanted]
        there |= {wanted: usable[0]} if usable else {}
    return there


class Environment:
    """A copy of the checkout with a virtual environment in it."""

    def __init__(self, python: str | Path, folder: str):
        self.root = Path(folder) / "checkout"
        hidden = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info", "__pycache__")
        shutil.copytree(ROOT, self.root, ignore=hidden)
        store = {"CLEARANCE_STORE": f"{folder}/store", "NUMBA_CACHE_DIR": f"{folder}/numba"}
        self.options = {"cwd": self.root, "env": os.environ | store}
        output(python, "-m", "venv", self.root / ".venv")
        self.python = self.root / ".venv" / "bin" / "python"

    def pip(self, *words: str) -> str:
        return output(self.python, "-m", "pip", *words, **self.options)

    def has_wheel(self, pin: str) -> bool:
        """Release that pip installs here without building it."""
        words = ("install", "-q", "--dry-run", "--no-deps", "--only-binary", ":all:", pin)
        try:
            self.pip(*words)
        except Failure:
            return False
        return True

    def lowest(self, requirement: Requirement) -> str:
        """Pin of the lowest release that is allowed and has a wheel."""
        listed = re.search(
            r"Available versions: (.*)", self.pip("index", "versions", requirement.name)
        )
        allowed = sorted(requirement.specifier.filter(listed[1].split(", ")), key=Version)
        pins = (f"{requirement.name}=={release}" for release in allowed)
        if pin := next(filter(self.has_wheel, pins), None):
            return pin
        raise Failure(f"no release of {requirement} has a wheel")

    def install(self, which: str) -> None:
        """The package, a set of its dependencies, and those of the tests."""
        pins = [self.lowest(r) for r in CORE] if which == "lowest" else []
        extra = PROJECT["optional-dependencies"]["test"]
        tools = [line for line in extra if Requirement(line).name in TOOLS]
        wheels = ",".join(r.name for r in CORE)
        self.pip("install", "-q", "--no-compile", "--only-binary", wheels, ".", *pins, *tools)

    def versions(self) -> dict[str, str]:
        """Of all that is installed, by name."""
        listed = json.loads(self.pip("list", "--format", "json"))
        return {entry["name"].lower(): entry["version"] for entry in listed}

    def readme(self) -> None:
        """README's first command, after its install."""
        block = re.search(r"```sh\n(.*?)\n```", (ROOT / "README.md").read_text(), re.DOTALL)[1]
        output(*shlex.split(block.split(" && ")[-1]), **self.options)

    def tests(self, which: str) -> tuple[dict[str, int], list[str]]:
        """Tests by their ends, and the lines of those that failed."""
        words = ["-m", "pytest", "-q", "-rfE", "-p", "no:cacheprovider", *WARNINGS[which], *TESTS]
        done = subprocess.run([self.python, *words], capture_output=True, text=True, **self.options)
        lines = done.stdout.splitlines() or [""]
        counts = {end: int(n) for n, end in COUNTED.findall(lines[-1])}
        bad = [line for line in lines if line.startswith(("FAILED ", "ERROR "))]
        if done.returncode and not bad:
            bad = [*lines[-5:], done.stderr.strip()[-500:]]
        return counts, bad


def cells(python: str | Path, which: str) -> tuple[list[str], list[str]]:
    """Versions, the end of the command and counts of tests; and the lines of failures."""
    done = ["-"] * (len(CORE) + 3)
    with tempfile.TemporaryDirectory() as folder:
        try:
            environment = Environment(python, folder)
            environment.install(which)
            versions = environment.versions()
            done[: len(CORE)] = [versions[r.name.lower()] for r in CORE]
            done[-3] = "failed"
            environment.readme()
        except Failure as failure:
            return done, [str(failure)]
        counts, bad = environment.tests(which)
        failed = max(counts.get("failed", 0) + counts.get("error", 0), bool(bad))
        return [*done[:-3], "ran", str(counts.get("passed", 0)), str(failed)], bad


def table(chosen) -> list[str]:
    """A row for each Python and set."""
    if unknown := set(chosen.sets) - set(WARNINGS):
        raise SystemExit(f"sets are {', '.join(WARNINGS)}; got {', '.join(unknown)}")
    pythons = {version(path): path for path in chosen.python} or interpreters()
    if None in pythons:
        raise SystemExit(f"{pythons[None]} is no Python that starts")
    names = ["Python", "set", *(r.name for r in CORE), "command", "passed", "failed"]
    rows = [names, ["---"] * len(names)]
    for minor, python in pythons.items():
        for which in chosen.sets:
            done, bad = cells(python, which)
            rows.append([minor, which, *done])
            for line in bad:
                require(False, f"Python {minor}, {which}: {line}")
            print(" ".join(rows[-1]), file=sys.stderr, flush=True)
    if absent := set(supported()) - set(pythons):
        print(f"not run: Python {', '.join(sorted(absent))}")
    require(pythons, "no Python of the classifiers")
    return [f"| {' | '.join(row)} |" for row in rows]


if __name__ == "__main__":
    publish(
        __doc__,
        table,
        MARK,
        python=([], "interpreters to take"),
        sets=([*WARNINGS], "of versions"),
    )
