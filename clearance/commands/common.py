"""Shared parts of commands: exit status, numbers with units, folders, what cannot be read."""

import argparse
import contextlib
import json
import logging
import math
import sys
import textwrap
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

from clearance.commands import COMMANDS
from clearance.files.texts import listed as listed
from clearance.files.texts import shortened
from clearance.run.progress_bar import ProgressBar
from clearance.values import checks
from clearance.values.spelling import taken as taken

DONE, FAILED, WRONG = 0, 1, 2
WARNED = "  warning      {}"
GOES_ON = "the same command goes on where this stopped"
#: names of options in the code, where they are others
DESTINATIONS = {"-o": "output", "-p": "parameters", "--from": "start"}


def add_command(commands, name: str, help: str = "", **more) -> argparse.ArgumentParser:
    """A command whose own help begins with its line in the list of commands; help: that line, of
    one that `COMMANDS` does not have. An epilog of several lines keeps them.
    """
    help = help or COMMANDS[name]
    if "\n" in (more.get("epilog") or ""):
        more["formatter_class"] = argparse.RawDescriptionHelpFormatter
    return commands.add_parser(name, help=help, description=f"{help[0].upper()}{help[1:]}.", **more)


def log_to_terminal(options) -> None:
    """Show remarks and progress of the loggers; nothing of them under --json."""
    if options.json:
        return
    logging.basicConfig(level=logging.INFO, format="clearance: %(message)s")
    logging.getLogger("skfem").setLevel(logging.WARNING)  # it reports every basis


def quantity_of(units: str):
    """A parser of numbers with an optional unit, in SI."""

    def parse(text: str) -> float:
        from clearance.values.units import quantity

        try:
            return quantity(text, units)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return parse


def number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


#: what reads an option with a default of this kind
PARSERS = {int: int, float: number}


def share(text: str) -> float:
    """A tolerance: 1e-3, 5%."""
    try:
        return checks.share("tolerance", text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


#: what may stand behind a metavar
FORMS: dict[str, dict] = {"...": {"default": [], "action": "append"}, "!": {"required": True}}
FORMS |= {count: {"nargs": count} for count in "*+?"}


def add_options(command, options: dict):
    """Options and arguments by their words, which are name and metavar: "--points N". One without a
    metavar is a flag. Behind the metavar may stand "...", it may be repeated, "!", it is required,
    or how many words it takes, as argparse has it.

    Each has its help, (default, help), or (kind, default, help). kind: a parser, or the unit of a
    number; without it that of the default. The help states the default. A dictionary has the words
    of argparse; that of "one of" has options that exclude each other.
    """
    for words, entry in options.items():
        if words == "one of":
            add_options(command.add_mutually_exclusive_group(), entry)
            continue
        if isinstance(entry, dict):
            command.add_argument(words, **entry)
            continue
        name, metavar, form = (*words.split(), "", "")[:3]
        *kind, default, text = (None, entry) if isinstance(entry, str) else entry
        parser = kind[0] if kind else PARSERS.get(type(default))
        parser = quantity_of(parser) if isinstance(parser, str) else parser
        about = {"default": default, "metavar": metavar, "type": parser} | FORMS.get(form, {})
        if not metavar:
            about = {"default": False, "action": "store_true"}
        elif form == "...":
            text += "; may be repeated"
        elif default is not None:
            shown = f"{default:g}" if isinstance(default, float) else default
            text += f" (default {shown})"
        if name in DESTINATIONS:
            about["dest"] = DESTINATIONS[name]
        command.add_argument(name, help=text.replace("%", "%%"), **about)
    return command


def pair(option: str, text: str, form: str = "NAME=VALUE") -> tuple[str, str]:
    """Name and value of an option. Raises ValueError for a text of another form."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        raise ValueError(f"{option} {text}: expected {form}")
    return name.strip(), value


def seed_of(options) -> int:
    """--seed. Raises ValueError for a negative one, and for one that no file can keep."""
    return checks.whole("--seed", options.seed, 0, 2**63 - 1)


def case_options(
    metavar: str = "NAME=VALUE",
    text: str = "a case parameter, such as speed=300rpm, clearance=0.1mm or clearance=H7/f7",
) -> dict:
    """The case and its parameters, for scene_of; metavar, text: of a parameter."""
    case = {"case CASE": "name of a case, or path to your own .py or .toml file"}
    return case | {f"-p {metavar} ...": text}


#: length of a run, in turns or seconds, for length_of
LENGTH = {
    "one of": {
        "--turns TURNS": (number, None, "length in turns of the drive (default 2)"),
        "--until S": (
            "s",
            None,
            "length in seconds (default, where nothing turns evenly, 2 s or UNTIL of the case "
            "file)",
        ),
    }
}
#: for requests that `clearance.run.options` refuses
FORCE = {"--force": "begin even what needs more than 2^31 rows, a day or the free disk"}
#: for what goes on from its directory
ACCEPT = {
    "--accept-changes": "go on although the package, a law, a file or a number of the scene has "
    "changed since"
}


def existing(path: str | Path) -> Path:
    """The path. Raises FileNotFoundError where nothing is there."""
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"no file or directory {path}")
    return path


def parameter_lines(case, values: dict, scene) -> list[str]:
    """The parameters of a case in print: those given, those of them that do nothing, and the
    defaults of the others, but for those that would do nothing. Those that are auto have what
    became of them, as far as it is known.
    """
    from clearance.scene.joint_options import idle
    from clearance.values.fit_class import Fitted
    from clearance.values.units import shown

    def text(name: str, value: object, units: str) -> str:
        more = f": {shown(resolved[name], units)}" if name in resolved else ""
        return shown(value, units) + more + (f" ({value.fit})" if isinstance(value, Fitted) else "")

    rows = case.parameters.items()
    resolved = json.loads(scene.origin.get("resolved", "{}"))
    without = idle(scene)
    chosen = [f"{n} = {text(n, values[n], p.units)}" for n, p in rows if n in values]
    default = [f"{n} {text(n, p.default, p.units)}" for n, p in rows if n not in values | without]
    vain = [f"{n} ({without[n]})" for n in case.parameters if n in values and n in without]
    parts = ("given", chosen), ("no effect", vain), ("default", default)
    return [f"  {t:<12} {', '.join(v)}" for t, v in parts if v]


def folded(lines: Iterable[str], head: int = 15) -> Iterator[str]:
    """Lines of at most 100 letters, which end behind a comma where they can; head: letters before
    the text of each.
    """
    style = {"break_on_hyphens": False, "break_long_words": False}
    for line in lines:
        parts = (p if len(p) > 60 else p.replace(" ", "\0") for p in line.split(", "))
        below = textwrap.wrap(", ".join(parts), 100, subsequent_indent=" " * head, **style)
        yield from (text.replace("\0", " ") for text in below)


def length_of(options, case, scene) -> dict[str, float | None]:
    """Turns or seconds: as requested, else two turns, else what the case states where nothing turns
    evenly.
    """
    if options.turns is None and options.until is None:
        return (
            {"turns": None, "until": case.until}
            if scene.turn is None
            else {"turns": 2.0, "until": None}
        )
    return {"turns": options.turns, "until": options.until}


def json_text(document, indent: int | None = None) -> str:
    """A document as strict JSON: what is not a finite number is null."""
    return json.dumps(_finite(document), indent=indent, allow_nan=False)


def _finite(value):
    if isinstance(value, dict):
        return {name: _finite(v) for name, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def complain(options, message: str, status: int, **more) -> int:
    """One line on stderr, and under --json a document on stdout; returns the exit status.

    Below the line of what failed stand its warnings, by default those of the scene.
    """
    line = shortened(" ".join(message.split()))
    lines = [f"clearance: {line}"]
    if status == FAILED and hasattr(options, "scene"):
        more = {"warnings": options.scene.doubts} | more
        lines += map(WARNED.format, more["warnings"])
    if options.json:
        state = "failed" if status == FAILED else "wrong input"
        print(json_text({"status": state, "message": line, **more}))
    print("\n".join(lines), file=sys.stderr)
    return status


def texts_of(options, names: dict) -> dict[str, str]:
    """Names and texts of all -p NAME=VALUE. Raises ValueError for a name the case does not have or
    that stands twice.
    """
    values: dict[str, str] = {}
    for item in options.parameters:
        name, text = pair("-p", item)
        checks.known("the case has no parameter", name, names)
        if name in values:
            raise ValueError(f"-p {item}: {name} is given twice, {values[name]} before")
        values[name] = text
    return values


def quiet(options):
    """Under --json, what a case file prints goes to stderr."""
    return contextlib.redirect_stdout(sys.stderr) if options.json else contextlib.nullcontext()


def case_of(options):
    """The case requested."""
    from clearance.scene.catalogue import find_case

    with quiet(options):
        return find_case(options.case)


def scene_of(options):
    """The case requested, its parameters as given, and its scene."""
    case = case_of(options)
    with quiet(options):
        values = case.read(texts_of(options, case.parameters))
        scene = case.scene(**values)
    return case, values, of_command(scene, options)


def of_command(scene, options):
    """The scene, which remembers its command, and is remembered."""
    scene.origin["command"] = getattr(options, "line", "")
    options.scene = scene
    return scene


def channel_patterns(text: str | None) -> list[str] | None:
    """--channels: a comma list of paths and patterns; "all", "none"."""
    if text is None or text == "all":
        return None
    return [] if text in ("none", "") else listed(text)


def make_folder(options) -> None:
    """The folder of -o, where one is given. Raises ValueError where that is a file."""
    if not options.output:
        return
    folder = Path(options.output)
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"-o {folder} is a file; give the name of a folder")
    folder.mkdir(parents=True, exist_ok=True)


@contextlib.contextmanager
def noted(note: str) -> Iterator[None]:
    """The note of an interrupt that does not state what is stored."""
    try:
        yield
    except KeyboardInterrupt as request:
        if not hasattr(request, "__notes__"):
            request.add_note(note)
        raise


def show(options, document: dict, lines: Iterable[str], status: int = DONE) -> int:
    """Print a document, or lines for people, and return the exit status."""
    if options.json:
        print(json_text(document))
    elif not getattr(options, "quiet", False):
        print("\n".join(lines))
    return status


def publish(options, lines: list[str], document: dict, save, draw, study, stem: str) -> int:
    """Print a study, and with -o keep its table, picture and data."""
    if options.output:
        folder = Path(options.output)
        document["files"] = [
            str(save(study, folder)),
            str(draw(study, folder / f"{stem}.png")),
            str(folder / f"{stem}.md"),
        ]
        (folder / f"{stem}.md").write_text("\n".join(lines) + "\n")
        lines = [*lines, "", *(f"wrote {f}" for f in document["files"])]
    return show(options, document, lines)


def progress_of(options) -> ProgressBar:
    """Progress of a command on stderr; none under --json and --quiet."""
    silent = options.json or getattr(options, "quiet", False)
    return ProgressBar(options.command, partial(print, "clearance:", file=sys.stderr), silent)
