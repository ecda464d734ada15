"""`clearance report`: one HTML file about a run or a sweep."""

from pathlib import Path

from clearance.commands.common import existing, number, pair, show

OPTIONS = {
    "input FILE_OR_DIR": "run file, or sweep directory",
    "-o OUT.html": "report (default FILE.html beside a run file, report.html in a sweep directory)",
    "--settle N": (
        number,
        None,
        "turns of a run's start-up, whose numbers stand apart (default 1)",
    ),
    "--section BODY=SIZES ...": "cross-section of a link, whose bending is estimated: a "
    "diameter, as rod=12mm, or width and height in the plane, as rod=10mmx20mm (default: a "
    "round steel bar of its mass)",
}


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
    document = {"status": "complete", "report": str(path), "bytes": size}
    return show(options, document, [f"wrote {path} ({size / 1e3:.0f} kB)"])


def _sections(options) -> dict[str, tuple[float, ...]]:
    """Sizes [m] by body. Raises ValueError for what are none."""
    from clearance.values.units import quantity

    sections = {}
    for text in options.section:
        body, sizes = pair("--section", text, "BODY=DIAMETER or BODY=WIDTHxHEIGHT")
        sections[body] = tuple(quantity(size, "m") for size in sizes.split("x"))
    return sections


def default(source: Path) -> Path:
    """Default file of a report."""
    return source / "report.html" if source.is_dir() else source.with_suffix(".html")
