"""One process at a time: locks that end with the process that holds them.

Files and folders of fixed names are no links: who else may write in a folder could lead them
elsewhere. Files are replaced completely or not at all.
"""

import errno
import itertools
import logging
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

try:
    import fcntl
except ImportError:  # a system without file locks
    fcntl = None


SIGN = "process "
SIGNED = 300  # letters of a signed lock, at most


class InUse(ValueError):
    """Somebody else holds the lock."""


class Foreign(ValueError):
    """A name is taken by something that this package did not make."""


def opener(path: str | Path, flags: int) -> int:
    """For `open`: a plain file, made where there is none. Raises Foreign for anything else."""
    flags |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        descriptor = os.open(path, flags, 0o666)
    except OSError as error:
        if error.errno not in (errno.ELOOP, errno.EMLINK, errno.ENXIO):
            raise
        raise Foreign(f"{path} is a link or no plain file; remove it") from None
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise Foreign(f"{path} is no plain file; remove it")
    return descriptor


def folder_at(path: Path) -> Path:
    """A folder, made where there is none. Raises Foreign for a link."""
    if path.is_symlink():
        raise Foreign(f"{path} is a link; remove it, or take another directory")
    path.mkdir(parents=True, exist_ok=True)
    return path


class Lock:
    """A file that one holder at a time locks: a process, or a thread of one.

    It is removed when it is released.

    The file of a killed holder is locked by nobody and is taken over. `held` is False where the
    system or the file system has no locks. Raises InUse where another one holds it, unless `wait`
    is set; OSError where the file cannot be made; Foreign for a file that no lock is.
    """

    def __init__(self, path: Path, message: str = "", wait: bool = False):
        self.path = path
        self.file: IO | None = None
        while fcntl is not None and self.file is None:
            file = open(path, "a+", opener=opener, errors="replace")  # noqa: SIM115
            if not _is_lock(file):
                raise Foreign(f"{path} holds something else than a lock; remove it")
            try:
                fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            except BlockingIOError:
                raise InUse(f"{message} ({_holder(file)})") from None
            except OSError:  # a file system without locks
                file.close()
                with suppress(OSError):
                    path.unlink()
                return
            if self._is_ours(file):
                self.file = file
            else:  # its last holder has removed it
                file.close()
        self._sign()

    @property
    def held(self) -> bool:
        """The lock is this one's."""
        return self.file is not None

    def _is_ours(self, file: IO) -> bool:
        """The file still stands under its name."""
        try:
            return os.path.samestat(os.fstat(file.fileno()), os.stat(self.path))
        except FileNotFoundError:
            return False

    def _sign(self) -> None:
        """Write who holds it. A full disk leaves it unsigned."""
        if self.file is not None:
            with suppress(OSError):
                # truncating a new file makes some file systems write it out
                if os.fstat(self.file.fileno()).st_size:
                    self.file.truncate(0)
                self.file.write(f"{SIGN}{os.getpid()} on {os.uname().nodename}")
                self.file.flush()

    def release(self) -> None:
        """Remove the file, then let go of it: nobody else can hold a file that is removed here."""
        if self.file is not None:
            file, self.file = self.file, None
            with suppress(OSError):  # the folder has gone, or takes no changes any more
                self.path.unlink()
            with suppress(OSError):  # a full disk
                file.close()

    def __enter__(self) -> "Lock":
        return self

    def __exit__(self, *_) -> None:
        self.release()


def _is_lock(file: IO) -> bool:
    """The file is new, or a lock has signed it."""
    file.seek(0)
    if (text := file.read(SIGNED + 1)) and not (text.startswith(SIGN) and len(text) <= SIGNED):
        file.close()
        return False
    return True


def _holder(file: IO) -> str:
    with file:
        file.seek(0)
        return file.read().strip() or "another process"


LOG = logging.getLogger("clearance.files")
_count = itertools.count()


def check_replaceable(path: Path) -> None:
    """A file may take this name.

    Raises ValueError for a directory, and for a device, a pipe or a socket, which would be lost.
    """
    if path.exists() and not path.is_file():
        kind = "directory" if path.is_dir() else "device, a pipe or a socket"
        raise ValueError(f"{path} is a {kind}; give the name of a file")


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


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file under a temporary name, so completely or not at all."""
    with replacing(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


@contextmanager
def locked(folder: Path, doing: str) -> Iterator[None]:
    """One process at a time in a folder, where the system has file locks; they end with the process
    that holds them.

    The folder is made where it is not there. doing: what the other one is doing, for the message.
    Raises ValueError where the folder is in use.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with Lock(folder / "lock", f"{folder} is in use: another process is {doing}") as lock:
        if not lock.held:
            LOG.warning("this file system has no locks: see that nobody else uses %s", folder)
        yield


def temporary_file() -> Path:
    """A place for the file of a run without one, in a folder of its own."""
    return Path(tempfile.mkdtemp(prefix="clearance-")) / "run.h5"
