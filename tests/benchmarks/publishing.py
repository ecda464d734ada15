"""Shared parts of the scripts: tables into a file at their marks, numbers that are requested and
not met.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

END = "<!-- end -->"
#: where tables stand
RESULTS = Path(__file__).parent / "README.md"
missed: list[str] = []


def require(met, message: str) -> None:
    """Note a number that is not met; the script then ends with exit status 1."""
    if not met:
        missed.append(message)


def put(path: str | Path, lines: list[str], begin: str, end: str = END) -> None:
    """Put lines into a text file in place of what stands between two marks; `begin` must be there
    once.
    """
    head, _, tail = parts(path, begin, end)
    Path(path).write_text(f"{head}{begin}\n\n" + "\n".join(lines) + f"\n\n{tail}")


def put_rows(path: str | Path, lines: list[str], begin: str, end: str = END) -> None:
    """Put a table as `put` does; rows of other names stay as they are."""
    rows = [row for row in parts(path, begin, end)[1].splitlines() if row.startswith("| ")]
    there = {row.split("|")[1]: row for row in rows} | {row.split("|")[1]: row for row in lines[2:]}
    there.pop(lines[0].split("|")[1], None)
    put(path, [*lines[:2], *there.values()], begin, end)


def parts(path: str | Path, begin: str, end: str) -> tuple[str, str, str]:
    """The text of a file before a mark, between it and the end, and from the end on."""
    head, _, rest = (text := Path(path).read_text()).partition(begin)
    if text.count(begin) != 1 or end not in rest:
        raise SystemExit(f"{path} must have {begin} once, and after it {end!r}")
    inner, _, tail = rest.partition(end)
    return head, inner, (end + tail).lstrip("\n")


def options(doc: str, arguments: list[str] | None = None, **more) -> argparse.Namespace:
    """Options of a script, and --update.

    more: name -> default and text. False is a switch, a list takes several words, a type has no
        default; `names` and `paths` have no flag.
    """
    parser = argparse.ArgumentParser(description=doc.partition("\n")[0])
    more["update"] = False, f"put the tables into {RESULTS}"
    for name, (default, text) in more.items():
        if default is False:
            how = {"action": "store_true"}
        elif isinstance(default, list):
            how = {"nargs": "*", "type": type((default or [""])[0]), "default": default}
        elif isinstance(default, type):
            how = {"type": default}
        else:
            how = {"type": type(default), "default": default}
        parser.add_argument(name if name in ("names", "paths") else f"--{name}", help=text, **how)
    return parser.parse_args(arguments)


def publish(doc: str, make: Callable[..., list[str]], begin: str, end: str = END, **more) -> None:
    """A complete script: prints the lines, with --update puts them at their mark, states what was
    missed, and exits.

    more: more options, see `options`; `make` is called with them.
    """
    chosen = options(doc, **more)
    lines = make(chosen) if more else make()
    print("\n".join(lines))
    if chosen.update:
        put(RESULTS, lines, begin, end)
    print("\n".join(["", *(f"missed: {m}" for m in missed)]))
    sys.exit(1 if missed else 0)
