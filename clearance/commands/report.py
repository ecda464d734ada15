"""`clearance report`: one HTML file about a run or a sweep."""

import argparse
from pathlib import Path

from clearance.commands.common import DONE, add_command, existing, json_text, number


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "report")
    p.add_argument("input", metavar="FILE_OR_DIR", help="run file, or sweep directory")
    p.add_argument(
        "-o",
        dest="output",
        metavar="OUT.html",
        help="report (default FILE.html beside a run file, report.html in a sweep directory)",
    )
    p.add_argument(
        "--settle",
        type=number,
        metavar="N",
        help="turns of a run's start-up, whose numbers stand apart (default 1)",
    )
    p.add_argument(
        "--section",
        action="append",
        default=[],
        metavar="BODY=SIZES",
        help="cross-section of a link, whose bending is estimated: a diameter, as rod=12mm, or "
        "width "
        "and height in the plane, as rod=10mmx20mm (default: a round steel bar of its mass)",
    )
    return p


def run(options) -> int:
    """Write the report and print its path.

    Raises FileNotFoundError or ValueError for what is no run and no sweep.
    """
    from clearance.postprocess.report import report

    source = existing(options.input)
    path = report(
        source,
        options.output or default(source),
        settle=options.settle,
        sections=_sections(options),
    )
    size = path.stat().st_size
    if options.json:
        print(json_text({"status": "complete", "report": str(path), "bytes": size}))
    else:
        print(f"wrote {path} ({size / 1e3:.0f} kB)")
    return DONE


def _sections(options) -> dict[str, tuple[float, ...]]:
    """Sizes [m] by body. Raises ValueError for what are none."""
    from clearance.values.units import quantity

    sections = {}
    for text in options.section:
        body, equals, sizes = text.partition("=")
        if not equals:
            raise ValueError(f"--section {text}: expected BODY=DIAMETER or BODY=WIDTHxHEIGHT")
        sections[body] = tuple(quantity(size, "m") for size in sizes.split("x"))
    return sections


def default(source: Path) -> Path:
    """Default file of a report."""
    return source / "report.html" if source.is_dir() else source.with_suffix(".html")
