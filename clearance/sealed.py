"""Files that hold programs, behind a digest of their content and of what they were made from.

A damaged or foreign file is not used, and the log states it. This is no protection against someone
who may write there.
"""

import hashlib
import logging
import os
import threading
from pathlib import Path

LOG = logging.getLogger("clearance")
SIZE = hashlib.sha256().digest_size


def sealed(data: bytes, made_from: bytes) -> bytes:
    """The content of a file: the digest, then the data."""
    return hashlib.sha256(made_from + data).digest() + data


def opened(path: str | Path, made_from: bytes, warned: bool = False) -> bytes | None:
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
    """Write a file, completely or not at all; nothing where the folder takes none."""
    temporary = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(sealed(data, made_from))
        os.replace(temporary, path)
    except OSError:
        temporary.unlink(missing_ok=True)
