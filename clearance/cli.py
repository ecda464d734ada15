"""The command line: one thin layer over the Python interface; each command is a module of
`clearance.commands`.

Exit status: 0 done, 1 the run failed part-way (what it had is stored), 2 the input was wrong.
"""

import argparse
import errno
import gc
import json
import os
import re
import shlex
import sys
import warnings
from importlib import import_module
from pathlib import Path

from clearance.commands import COMMANDS
from clearance.commands.common import DONE, FAILED, WRONG, add_command, add_options, complain
from clearance.files.texts import shortened
from clearance.run import interrupts, progress_bar
from clearance.values.checks import RunWarning, meant
from clearance.version import VERSION

#: objects made between two searches for cycles among them; what imports and traces make stays, and
#: at Python's 700 the searches take a twelfth of a short run
OBJECTS = 100_000
JSON = {"--json": "one JSON document on stdout, nothing else"}


class Parser(argparse.ArgumentParser):
    """Wrong arguments are one clear line (and a JSON document where one is requested) and exit
    status 2.
    """

    def error(self, message: str):
        """Print the error and exit."""
        if choice := re.search(r"invalid choice: '(.*)' \(choose from (.*)\)", message):
            message += meant(choice[1], re.findall(r"[\w-]+", choice[2]))
        message = shortened(message)
        if "--json" in sys.argv:
            print(json.dumps({"status": "wrong input", "message": message}))
        self.exit(WRONG, f"clearance: {message}\n")


def parser(command: str | None = None) -> Parser:
    """All commands with their options; those of one command alone, if one is named: the modules of
    all others are not imported.
    """
    top = Parser(
        prog="clearance",
        description="Tribodynamics of planar mechanisms with clearance, lubricant, friction.",
    )
    top.add_argument("--version", action="version", version=f"clearance {VERSION}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, text in COMMANDS.items():
        if command in (None, name):
            _add(commands, name)
        else:
            commands.add_parser(name, help=text)
    return top


def _add(commands, name: str) -> None:
    """Add a command with the tables of its module: OPTIONS, EXAMPLES below its help, its USAGE."""
    module = import_module(f"clearance.commands.{name.replace('-', '_')}")
    texts = {
        n: getattr(module, word, None) for n, word in (("epilog", "EXAMPLES"), ("usage", "USAGE"))
    }
    command = add_command(commands, name, **texts)
    studies = module.added(command) if hasattr(module, "added") else [command]
    for study in studies:
        add_options(study, getattr(module, "OPTIONS", {}) | JSON)
        study.set_defaults(action=module.run, usual=study.get_default)


def main(arguments: list[str] | None = None) -> int:
    """Entry point: returns the exit status."""
    words = sys.argv[1:] if arguments is None else arguments
    commands = parser(next((word for word in words if not word.startswith("-")), ""))
    # argparse reads them as a list
    if empty := [word for word in words if re.fullmatch(r"--[a-z-]+=--", word)]:
        commands.error(f"argument {empty[0].partition('=')[0]}: expected a value, got '--'")
    options = commands.parse_args(_joined(words))
    options.line = shlex.join(["clearance", *words])
    progress_bar.by_command()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RunWarning)  # commands print them
            return options.action(options)
    except BrokenPipeError:  # the reader of our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        return complain(options, _words(error), FAILED if _full(error) else WRONG)
    except (ValueError, TypeError, ImportError) as error:
        return complain(options, str(error), WRONG)
    except RecursionError:
        return complain(options, "the input is nested too deep", WRONG)
    except (RuntimeError, ArithmeticError) as error:  # a solver that has no answer
        return complain(options, str(error), FAILED)
    except MemoryError as error:
        return complain(options, f"not enough memory{f': {error}' if str(error) else ''}", FAILED)
    except KeyboardInterrupt as request:
        return complain(
            options,
            "; ".join([interrupts.ended(request), *getattr(request, "__notes__", [])]),
            FAILED,
        )


def _words(error: OSError) -> str:
    """The system's reason and the file, or the directory of a temporary one.

    The system names no file where the working directory is gone.
    """
    if error.errno == errno.ENOENT and not error.filename and not os.stat(os.curdir).st_nlink:
        return f"the working directory {os.environ.get('PWD', os.curdir)} does not exist any more"
    if not error.filename or not error.strerror:
        return str(error)
    path = Path(str(error.filename))
    return (
        f"{f'directory {path.parent}' if '.partial' in path.suffixes else path}: {error.strerror}"
    )


def _full(error: OSError) -> bool:
    """The disk is full: the input was right, and another try may do."""
    from clearance.results.stream import FULL

    return error.errno in FULL


def _joined(arguments: list[str]) -> list[str]:
    """`--rtol -1e-6` as `--rtol=-1e-6`: argparse takes only plain negative numbers for values."""
    words: list[str] = []
    for argument in arguments:
        if re.match(r"-\.?\d", argument) and words and re.fullmatch(r"--[a-z-]+", words[-1]):
            words[-1] += f"={argument}"
        else:
            words.append(argument)
    return words


def entry() -> None:
    """The console script."""
    gc.set_threshold(OBJECTS)
    try:
        interrupts.begun()
        status = main()
    except KeyboardInterrupt as request:  # a second one, while the first was answered
        interrupts.over()
        print(f"clearance: {interrupts.ended(request)}", file=sys.stderr)
        status = FAILED
    finally:
        interrupts.over()
        gc.freeze()  # the end of the process needs no search: it takes a tenth of a short run
    sys.exit(status)


if __name__ == "__main__":
    entry()
