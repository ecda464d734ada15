"""Digests of Python files: of what they compute, whatever their comments, docstrings and layout
are.

Caches are named by them, so that a changed sentence rebuilds nothing.
"""

import ast
import hashlib
import json
import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import RLock

from clearance.files import sealed

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
    ledger = sealed.folder() / LEDGER
    before = json.loads(sealed.read(ledger, LEDGER.encode()) or b"{}")
    now = {str(path): _entry(str(path), before) for path in paths}
    if before | now != before:
        both = {path: entry for path, entry in (before | now).items() if os.path.exists(path)}
        sealed.write(ledger, json.dumps(both).encode(), LEDGER.encode())
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
