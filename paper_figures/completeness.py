"""The four sources, item by item: `python paper_figures/completeness.py [--update]`.

Prints the tables made of completeness.toml: each item and the command that answers it. With
--update
they are put into README.md of this folder.
"""

import sys
import tomllib
from collections import Counter
from pathlib import Path

from clearance.paper_figures.workshop import GROUPS

from clearance.files.locks import replacing

FOLDER = Path(__file__).parent
DATA, README = FOLDER / "completeness.toml", FOLDER / "README.md"
BEGIN, END = "<!-- completeness:begin -->", "<!-- completeness:end -->"
KINDS = ("model", "figure", "table", "study")
IMPOSSIBLE = "not possible"
RESULTS = ("reproduced", "trend only", IMPOSSIBLE)
FIELDS = {"item", "kind", "commands", "result", "note"}
HEAD = ("in the source", "kind", "command", "result", "note")


def rows() -> dict[str, list[dict]]:
    """The items of each source by the name of its group.

    Raises ValueError for an unknown group, field, kind or result, and for an impossible item
    without a reason.
    """
    sources = tomllib.loads(DATA.read_text(encoding="utf-8"))
    if unknown := [name for name in sources if name not in GROUPS]:
        raise ValueError(f"{DATA.name}: no group {unknown[0]!r}; there are {', '.join(GROUPS)}")
    for row in (row for items in sources.values() for row in items):
        _check(row)
    return sources


def _check(row: dict) -> None:
    where = f"{DATA.name}, {row.get('item', 'item without a text')!r}"
    if set(row) != FIELDS:
        fields, got = ", ".join(sorted(FIELDS)), ", ".join(sorted(row))
        raise ValueError(f"{where}: fields are {fields}; got {got}")
    for name, choices in (("kind", KINDS), ("result", RESULTS)):
        if row[name] not in choices:
            raise ValueError(f"{where}: {name} is one of {', '.join(choices)}; got {row[name]!r}")
    if row["result"] == IMPOSSIBLE and not row["note"]:
        raise ValueError(f"{where}: the note must complete 'not possible because ...'")
    if row["result"] != IMPOSSIBLE and not row["commands"]:
        raise ValueError(f"{where}: a command that answers it is missing")


def tables() -> list[str]:
    """A table for each source, as lines of Markdown."""
    lines = []
    for name, items in rows().items():
        counts = Counter(row["result"] for row in items)
        counted = ", ".join(f"{counts[result]} {result}" for result in RESULTS)
        lines += [f"### {GROUPS[name]}", "", f"{len(items)} items: {counted}.", ""]
        lines += [_line(HEAD), "|---" * len(HEAD) + "|", *map(_row, items), ""]
    return lines[:-1]


def _row(row: dict) -> str:
    impossible = row["result"] == IMPOSSIBLE
    result = f"{IMPOSSIBLE} because {row['note']}" if impossible else row["result"]
    commands = "<br>".join(f"`{command}`" for command in row["commands"])
    return _line([row["item"], row["kind"], commands, result, "" if impossible else row["note"]])


def _line(cells) -> str:
    return f"| {' | '.join(cells)} |"


def updated(text: str) -> str:
    """README with the tables between its marks."""
    before, _, rest = text.partition(BEGIN)
    after = rest.partition(END)[2]
    return "\n".join([f"{before}{BEGIN}", "", *tables(), "", f"{END}{after}"])


if __name__ == "__main__":
    if sys.argv[1:] == ["--update"]:
        with replacing(README) as temporary:
            temporary.write_text(updated(README.read_text(encoding="utf-8")), encoding="utf-8")
    elif sys.argv[1:]:
        raise SystemExit(f"unknown {' '.join(sys.argv[1:])}; the only option is --update")
    else:
        print("\n".join(tables()))
