"""The table of validation: tests state what they compare with which number; `--validation-table
FILE` writes a page.

A pytest plugin, loaded by tests/conftest.py. Tests with the fixture `validated` carry the marker
`validation`.
"""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

KINDS = {
    "published": "digits printed by others",
    "independent": "another implementation, method or code",
    "exact": "a closed form, a conservation law or a limit",
}
#: heading of the page -> beginnings of test ids, the longest that fits decides
SUBJECTS = {
    "Oil films": (
        "tests/film/",
        "tests/run/test_fields.py",
        "tests/laws/test_laws.py::TestPinkus",
        "tests/laws/test_elastic_gap.py",
        "tests/laws/test_joint_laws.py::TestFilms",
    ),
    "Contact": (
        "tests/laws/test_laws.py",
        "tests/laws/test_joint_laws.py::TestContact",
        "tests/stepping/test_stepping.py::test_hertz",
    ),
    "Rough surfaces": ("tests/laws/test_joint_laws.py",),
    "Wear": ("tests/validation/test_wear.py",),
    "Mechanisms": ("tests/validation/", "tests/mechanism/test_mechanics.py", "tests/sweeping/"),
    "Inverse dynamics": ("tests/motions/",),
    "Joint friction": (
        "tests/cases/test_friction_cases.py",
        "tests/elements/test_rubbing.py",
        "tests/laws/test_joint_friction_laws.py",
        "tests/elements/test_joint_lugre.py",
        "tests/laws/test_joint_laws.py::TestFriction",
    ),
    "Integrators": (
        "tests/stepping/test_tableaus.py",
        "tests/stepping/test_stepping.py",
        "tests/paper_figures/test_evidence.py",
    ),
    "Periodic motion": ("tests/motions/test_periodic.py", "tests/motions/test_follow.py"),
    "Lyapunov exponents and spectra": ("tests/motions/test_lyapunov.py", "tests/postprocess/"),
    "Ball-joint friction": ("tests/identify/",),
    "Other": ("",),
}
COMMAND = "pytest -m validation --validation-table tests/validation/README.md"
HEAD = (
    "quantity",
    "source",
    "kind",
    "checked against",
    "largest deviation",
    "tolerance",
    "status",
    "test",
)


@pytest.fixture
def validated(record_property: Callable) -> Callable:
    """A function that compares numbers with a reference, records the comparison as a row and fails
    where it is off.
    """

    def compare(
        quantity, result, reference, tolerance, *, source, unit="", kind="published", relative=True
    ):
        """Assert |result - reference| <= tolerance for numbers or arrays of one shape [unit];
        complex numbers are vectors.

        The deviation is a share of each reference value, with relative=False a number of units, or
        the share of a size [unit] given as `relative`. ValueError: kind is unknown.
        """
        if kind not in KINDS:
            raise ValueError(f"kind must be one of {', '.join(KINDS)}; got {kind!r}")
        result, reference = np.broadcast_arrays(np.asarray(result), np.asarray(reference))
        first = reference.flat[0]
        row = {
            "quantity": quantity,
            "source": source,
            "kind": kind,
            "unit": unit,
            "share": relative is not False,
            "count": reference.size,
            "value": float(abs(first) if np.iscomplexobj(first) else first),
            "tolerance": float(tolerance),
            "deviation": worst(
                result, reference, np.abs(reference) if relative is True else float(relative or 1.0)
            ),
        }
        record_property("validated", json.dumps(row))
        off = row["deviation"]
        assert off <= row["tolerance"], (
            f"{quantity}: off by {off:.3g}, allowed {tolerance:g}; {result} not {reference}"
        )

    return compare


def worst(result: np.ndarray, reference: np.ndarray, size: np.ndarray | float) -> float:
    """Largest share of `size` that the numbers are apart by; none where they are equal, nan where
    any is.
    """
    with np.errstate(all="ignore"):
        return float(np.max(np.where(result == reference, 0.0, np.abs(result - reference) / size)))


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option for the page."""
    parser.addoption(
        "--validation-table",
        metavar="FILE",
        help="write what `validated` compared to a Markdown page",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Name the marker; one process alone, no worker of xdist, gathers the rows."""
    config.addinivalue_line(
        "markers", "validation: compares with a published, exact or independent number"
    )
    path = config.getoption("--validation-table")
    if path and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Gathered(config.invocation_params.dir / path))


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that state rows."""
    for item in items:
        if "validated" in getattr(item, "fixturenames", ()):
            item.add_marker("validation")


class Gathered:
    """Rows of all reports of a session, and the page of them."""

    def __init__(self, path: Path):
        self.path, self.rows = path, {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the rows that a test stated, or a row that states why it stated none."""
        ended = report.when == "call" or (report.when == "setup" and not report.passed)
        if "validation" not in report.keywords or not ended:
            return
        test = report.nodeid.partition("[")[0]
        rows = [json.loads(text) for name, text in report.user_properties if name == "validated"]
        for rank, row in enumerate(rows):
            self.add(
                test,
                rank,
                row | {"status": "passed" if row["deviation"] <= row["tolerance"] else "FAILED"},
            )
        if not report.passed and all(row["deviation"] <= row["tolerance"] for row in rows):
            why = (
                f"not run: {report.longrepr[2].removeprefix('Skipped: ')}"
                if report.skipped
                else "FAILED"
            )
            self.add(test, len(rows), {"quantity": "the whole test", "status": why})

    def add(self, test: str, rank: int, row: dict) -> None:
        """Rows that differ by their values alone, as those of parametrised tests do, are one: their
        worst.
        """
        key = (
            test,
            *(
                row.get(n, "")
                for n in ("quantity", "source", "kind", "unit", "share", "tolerance", "status")
            ),
        )
        reference = self.rows.setdefault(
            key, row | {"test": test, "place": rank, "count": 0, "deviation": 0.0}
        )
        reference["place"] = min(reference["place"], rank)
        reference["count"] += row.get("count", 0)
        off = reference["deviation"], row.get("deviation", 0.0)
        reference["deviation"] = math.nan if any(map(math.isnan, off)) else max(off)

    def pytest_sessionfinish(self) -> None:
        """Write the page."""
        if self.rows:
            self.path.write_text(page(list(self.rows.values())))


def subject(test: str) -> str:
    """The heading a test id stands under."""
    return max(
        SUBJECTS,
        key=lambda name: max((len(b) for b in SUBJECTS[name] if test.startswith(b)), default=-1),
    )


def page(rows: list[dict]) -> str:
    """Markdown of rows, the same whatever order they came in."""
    kinds = list(KINDS)
    rows = sorted(
        rows,
        key=lambda r: (kinds.index(r["kind"]) if "kind" in r else 9, r["test"], r["place"], str(r)),
    )
    passed, failed, broken, idle = (
        sum(r["status"].startswith(status) and ("kind" in r) is stated for r in rows)
        for status, stated in (
            ("passed", True),
            ("FAILED", True),
            ("FAILED", False),
            ("not run", False),
        )
    )
    lines = [
        "# What is validated",
        "",
        f"Written by `{COMMAND}`; do not edit.",
        "",
        f"{passed + failed} comparisons of {sum(r['count'] for r in rows)} values: {passed} "
        f"passed, {failed} failed. "
        f"Whole tests: {broken} failed, {idle} not run.",
        "Values of a parametrised test stand in one row with the largest deviation among them.",
        "Deviations without a unit are shares of the reference (or of the size the test names).",
        "",
        *(f"- {name}: {meaning}" for name, meaning in KINDS.items()),
    ]
    for name in SUBJECTS:
        ours = [r for r in rows if subject(r["test"]) == name]
        if ours:
            lines += [
                "",
                f"## {name}",
                "",
                f"| {' | '.join(HEAD)} |",
                "|---" * len(HEAD) + "|",
                *map(line, ours),
            ]
    return "\n".join(lines) + "\n"


def line(row: dict) -> str:
    """One row of a table."""
    if "kind" not in row:
        cells = [row["quantity"], "", "", "", "", "", row["status"], f"`{row['test']}`"]
    else:
        unit = f" {row['unit']}" if row["unit"] else ""
        against = f"{row['value']:.10g}{unit}" if row["count"] == 1 else f"{row['count']} values"
        off, allowed = (
            f"{row[n]:.1e}{'' if row['share'] else unit}" for n in ("deviation", "tolerance")
        )
        cells = [
            row["quantity"],
            row["source"],
            row["kind"],
            against,
            off,
            allowed,
            row["status"],
            f"`{row['test']}`",
        ]
    return f"| {' | '.join(c.replace('|', '/').replace(chr(10), ' ') for c in cells)} |"
