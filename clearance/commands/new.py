"""`clearance new`: a scene file to begin with."""

import argparse
from pathlib import Path

from clearance import templates
from clearance.checks import meant
from clearance.commands.common import DONE, add_command, json_text


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "new", help="write a scene file of a mechanism, to run and to change")
    p.add_argument("mechanism", metavar="MECHANISM", help=f"one of {', '.join(templates.NAMES)}")
    p.add_argument("-o", dest="output", metavar="FILE", help="the file (default MECHANISM.toml)")
    return p


def run(options) -> int:
    """Write the file, never over another one."""
    name = options.mechanism
    if name not in templates.NAMES:
        answer = f"{meant(name, templates.NAMES)}; known: {', '.join(templates.NAMES)}"
        raise ValueError(f"unknown mechanism {name!r}{answer}")
    path = Path(options.output or f"{name}.toml")
    if path.suffix != ".toml":
        raise ValueError(f"-o {path}: the name of a scene file ends in .toml")
    if path.exists():
        raise ValueError(f"{path} is there already; give another name by -o")
    path.write_text(templates.text_of(name))
    print(
        json_text({"file": str(path)})
        if options.json
        else f"wrote {path}; clearance run {path} runs it"
    )
    return DONE
