"""Files that hold programs, behind a digest of their content and of what they were made from.

A damaged or foreign file is not used, and the log states it. This is no protection against someone
who may write there.
"""

import hashlib
import logging
import os
import threading
from contextlib import suppress
from pathlib import Path

LOG = logging.getLogger("clearance")
SIZE = hashlib.sha256().digest_size
_refusing: set[str] = set()  # folders that took no file


def sealed(data: bytes, made_from: bytes) -> bytes:
    """The content of a file: the digest, then the data."""
    return hashlib.sha256(made_from + data).digest() + data


def read(path: str | Path, made_from: bytes, warned: bool = False) -> bytes | None:
    """The data of a file; None where there is no file, or none that may be used.

    warned: the log has the warning already.
    """
    try:
        content = Path(path).read_bytes()
    except OSError:
        return None
    data = content[SIZE:]
    if content == sealed(data, made_from):
        return data
    if not warned:
        LOG.warning(f"compiled code {path} is damaged or of another program; it is made again")
    return None


def write(path: Path, data: bytes, made_from: bytes) -> None:
    """Write data behind its digest, see `put`."""
    put(path, sealed(data, made_from))


def put(path: Path, content: bytes) -> None:
    """Write a file, completely or not at all. The log states where a folder takes none."""
    temporary = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except OSError as reason:
        with suppress(OSError):
            temporary.unlink()
        refused(str(path.parent), reason.strerror)


def refused(folder: str, reason: str | None) -> None:
    """Log that a folder takes no files, once a process."""
    if folder not in _refusing:
        _refusing.add(folder)
        LOG.warning(f"store {folder} takes no files ({reason}); each process compiles again")
