"""Files are replaced completely or not at all."""

import itertools
import logging
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from clearance.files.locks import Lock

LOG = logging.getLogger("clearance.files")
_count = itertools.count()


def check_replaceable(path: Path) -> None:
    """A file may take this name.

    Raises ValueError for a device, a pipe or a socket, which would be lost.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise ValueError(f"{path} is a device, a pipe or a socket; give the name of a file")


def temporary_name(path: Path) -> Path:
    """A name beside a file that no other writer of it uses."""
    return path.with_name(f"{path.name}.{os.getpid()}.{next(_count)}.partial")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary name to write to; what is there at the end becomes `path`, completely or not at
    all.

    Raises ValueError as `check_replaceable` does.
    """
    check_replaceable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(path)
    temporary.unlink(missing_ok=True)
    try:
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        if error.errno and not error.filename:  # the system does not name what it could not write
            error.filename = str(path)
        raise
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def locked(folder: Path, doing: str) -> Iterator[None]:
    """One process at a time in a folder, where the system has file locks; they end with the process
    that holds them.

    doing: what the other one is doing, for the message. Raises ValueError where the folder is in
        use.
    """
    with Lock(folder / "lock", f"{folder} is in use: another process is {doing}") as lock:
        if not lock.held:
            LOG.warning("this file system has no locks: see that nobody else uses %s", folder)
        yield


def temporary_file() -> Path:
    """A place for the file of a run without one, in a folder of its own."""
    return Path(tempfile.mkdtemp(prefix="clearance-")) / "run.h5"
