"""Files that hold programs, behind a digest of their content and of what they were made from.

A damaged or foreign file is not used, and the log states it. Neither is a file or folder that
belongs to somebody else than the user or root, or that others can write. Folders of the store are
the user's alone, unless CLEARANCE_STORE names one.

Caches are named by digests of what Python files compute, whatever their comments, docstrings and
layout are: a changed sentence rebuilds nothing.
"""

import ast
import hashlib
import json
import logging
import os
import threading
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import RLock

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
    if (content := content_of(Path(path))) is None:
        return None
    data = content[SIZE:]
    if content == sealed(data, made_from):
        return data
    if not warned:
        LOG.warning(f"compiled code {path} is damaged or of another program; it is made again")
    return None


def content_of(path: Path) -> bytes | None:
    """The bytes of a file; None where there is none that may be used."""
    try:
        with open(path, "rb") as file:
            if reason := strange(os.fstat(file.fileno())):
                unused(path, reason)
            elif usable(path.parent):
                return file.read()
    except OSError:
        return None
    return None


def strange(state: os.stat_result) -> str:
    """The reason why a file or folder may be another one's work; "" where it is the user's."""
    if hasattr(os, "getuid") and state.st_uid not in (os.getuid(), 0):
        return f"it belongs to user {state.st_uid}"
    return "others than its owner can write it" if state.st_mode & 0o022 else ""


def usable(folder: Path) -> bool:
    """True for a folder whose files may be used; one of the store is made the user's alone.

    Raises OSError for one that is not there.
    """
    state = os.stat(folder)
    if private() and strange(state) and state.st_uid == getattr(os, "getuid", int)():
        os.chmod(folder, 0o700)  # of an older version; each of its files is looked at, too
        state = os.stat(folder)
    if reason := strange(state):
        unused(folder, reason)
    return not reason


def private() -> bool:
    """The store is nobody else's: no setting names a folder."""
    return not os.environ.get("CLEARANCE_STORE")


def ready(folder: Path) -> bool:
    """Make a folder; True where it may be used. Raises OSError where it cannot be made."""
    folder.mkdir(mode=0o700 if private() else 0o777, parents=True, exist_ok=True)
    return usable(folder)


def write(path: Path, data: bytes, made_from: bytes) -> None:
    """Write data behind its digest, see `put`."""
    put(path, sealed(data, made_from))


def put(path: Path, content: bytes) -> None:
    """Write a file, completely or not at all. The log states where a folder takes none."""
    temporary = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}.partial")
    try:
        if not ready(path.parent):
            return
        mode = 0o600 if private() else 0o644
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except OSError as reason:
        with suppress(OSError):
            temporary.unlink()
        refused(str(path.parent), reason.strerror)


def unused(path: Path, reason: str) -> None:
    """Log that a file or folder is not used, once a process."""
    if str(path) not in _refusing:
        _refusing.add(str(path))
        LOG.warning(f"store: {path} is not used, {reason}; what it holds is made again")


def refused(folder: str, reason: str | None) -> None:
    """Log that a folder takes no files, once a process."""
    if folder not in _refusing:
        _refusing.add(folder)
        LOG.warning(f"store {folder} takes no files ({reason}); each process compiles again")


def folder() -> Path:
    """Folder of the store."""
    if chosen := os.environ.get("CLEARANCE_STORE"):
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or _home() / ".cache"
    return Path(base) / "clearance" / "kernels"


def _home() -> Path:
    """The user's folder; where the user has none, a path where no file can be made."""
    try:
        return Path.home()
    except RuntimeError:
        return Path(os.devnull)


#: of the store: size [bytes], time [ns] and digest of each file; another form takes another number
LEDGER = "clearance_sources_1.json"
PARSING = RLock()  # Python 3.11 counts the depth of all syntax trees that threads make together
DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def parsed(source: str | bytes, mode: str = "exec") -> ast.Module | ast.Expression:
    """The syntax tree of a source, in any thread; anew where a stranger's thread makes one too."""
    while True:
        with PARSING, suppress(SystemError):  # "AST constructor recursion depth mismatch"
            return ast.parse(source, mode=mode)


@cache
def digest_of_code(*paths: str | Path) -> str:
    """Digest of the code of Python files, in their order; equal for all versions of Python.

    A syntax tree takes some ten milliseconds a file. So the store keeps the digest of each file,
    for as long as the file has its size and time.
    """
    ledger = folder() / LEDGER
    before = json.loads(read(ledger, LEDGER.encode()) or b"{}")
    now = {str(path): _entry(str(path), before) for path in paths}
    if before | now != before:
        both = {path: entry for path, entry in (before | now).items() if os.path.exists(path)}
        write(ledger, json.dumps(both).encode(), LEDGER.encode())
    return hashlib.sha256(" ".join(now[str(path)][-1] for path in paths).encode()).hexdigest()


def _entry(path: str, before: dict[str, list]) -> list:
    """Size, time and digest of a file; the digest is that of before where the others are."""
    state = os.stat(path)
    stamp = [state.st_size, state.st_mtime_ns]
    if path in before and before[path][:2] == stamp:
        return before[path]
    words: list[str] = []
    _tell(parsed(Path(path).read_bytes()), words)
    return [*stamp, hashlib.sha256(" ".join(words).encode()).hexdigest()]


def _tell(node: object, words: list[str]) -> None:
    """Add kinds, names and constants of a syntax tree to the words of it.

    Docstrings are left out, and empty fields and texts: versions of Python differ in these.
    """
    if isinstance(node, list):
        for item in node:
            _tell(item, words)
        words.append("]")
    elif isinstance(node, ast.AST):
        words.append(type(node).__name__)
        for name in node._fields:
            if (value := _content(node, name)) not in (None, []):
                words.append(name)
                _tell(value, words)
        words.append(")")
    else:
        words.append(ascii(node))


def _content(node: ast.AST, name: str) -> object:
    """A field of a node, without a docstring, and without the empty texts of a format."""
    value = getattr(node, name, None)
    if name == "body" and isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False):
        return value[1:]
    if isinstance(node, ast.JoinedStr):
        return [part for part in value if getattr(part, "value", None) != ""]
    return value
