"""Commands as one types them, run in this process; and processes of Python."""

import json
import shlex
import subprocess
import sys
from typing import NamedTuple

from clearance import cli


class Ended(NamedTuple):
    """Exit status of a command, and what it printed."""

    status: int
    out: str
    err: str

    @property
    def document(self):
        """The JSON that it printed."""
        return json.loads(self.out)


def words(*parts) -> list[str]:
    """Arguments of a command: texts are split as a shell does; paths and numbers are one each."""
    return [w for p in parts for w in (shlex.split(p) if isinstance(p, str) else [str(p)])]


def run(*arguments, capsys) -> Ended:
    """Exit status and output of one command, given argument by argument."""
    try:
        status = cli.main([str(a) for a in arguments])
    except SystemExit as stop:
        status = stop.code
    return Ended(status, *capsys.readouterr())


class Typed:
    """Runs commands; see the fixture `typed`."""

    def __init__(self, capsys):
        self.capsys = capsys

    def __call__(self, *parts, status=0) -> Ended:
        """The ended command, whose exit status is as expected."""
        ended = run(*words(*parts), capsys=self.capsys)
        assert ended.status == status, ended
        return ended

    def line(self, *parts, status=2) -> str:
        """The one line that a command gives as its reason, and prints nothing else."""
        ended = self(*parts, status=status)
        assert ended.out == ""
        assert ended.err.startswith("clearance: ")
        assert ended.err.count("\n") == 1
        assert len(ended.err) < 2000
        return ended.err.rstrip()


def python(*arguments, **more) -> subprocess.CompletedProcess:
    """A process of Python, which must end well; more: options of `subprocess.run`."""
    command = [sys.executable, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, **more)
    assert done.returncode == 0, done.stderr
    return done
