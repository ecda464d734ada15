"""`clearance new`: a scene file to begin with, or a Python case."""

import argparse
from pathlib import Path

from clearance import templates
from clearance.checks import meant
from clearance.commands.common import DONE, add_command, json_text


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "new", help="write a scene file of a mechanism, to run and to change")
    p.add_argument(
        "mechanism",
        metavar="MECHANISM",
        help=f"one of {', '.join(templates.NAMES)}; or your scene file, with --python",
    )
    p.add_argument("--python", action="store_true", help="write the same scene as a Python case")
    p.add_argument("-o", dest="output", metavar="FILE", help="the file (default MECHANISM.toml)")
    return p


def run(options) -> int:
    """Write the file, never over another one."""
    source = _source(options)
    suffix = ".py" if options.python else ".toml"
    path = Path(options.output or f"{source.stem}{suffix}")
    if path.suffix != suffix:
        kind = "Python case" if options.python else "scene file"
        raise ValueError(f"-o {path}: the name of a {kind} ends in {suffix}")
    if path.exists():
        raise ValueError(f"{path} is there already; give another name by -o")
    path.write_text(_text(source, options.python), encoding="utf-8")
    sentence = f"wrote {path}; clearance run {path} runs it"
    print(json_text({"file": str(path)}) if options.json else sentence)
    return DONE


def _source(options) -> Path:
    """The scene file that is written from."""
    name = options.mechanism
    if options.python and name.endswith(".toml"):
        if not Path(name).is_file():
            raise ValueError(f"no scene file {name}")
        return Path(name)
    if name not in templates.NAMES:
        answer = f"{meant(name, templates.NAMES)}; known: {', '.join(templates.NAMES)}"
        raise ValueError(f"unknown mechanism {name!r}{answer}")
    return templates.path_of(name)


def _text(source: Path, python: bool) -> str:
    if not python:
        return source.read_text(encoding="utf-8")
    from clearance.scene_python import python_of

    return python_of(source)
