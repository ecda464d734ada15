"""Texts of files and messages, read with care: only plain files, nothing endless, one error for
whatever is wrong with them.
"""

import gzip
import json
import re
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

LARGEST = 2**28  # bytes of a text that is read at once
LONG, SHOWN = 200, 60  # letters of a quoted value that is shortened, and those that stay
CHECK = "crc32"  # entry or attribute of what has a checksum
#: a quoted value, or what has no blank
QUOTED = re.compile(r"""(?<!\w)(?:'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*")(?!\w)|[^\s'"]+""", re.DOTALL)


def text_of(path: str | Path) -> str:
    """The text of a file, without the mark that some editors put before it.

    Raises ValueError for a device, a pipe, a text that is too long or is not in UTF-8; OSError.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        raise ValueError(f"{path} is no plain file")
    if (size := path.stat().st_size) > LARGEST:
        raise ValueError(f"{path} has {size} bytes; a text may have {LARGEST}")
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path} is not a text file in UTF-8") from None


def unpacked_text(path: str | Path) -> str:
    """The text of a file that gzip may have packed. Raises ValueError as `text_of`."""
    path = Path(path)
    if path.suffix != ".gz":
        return text_of(path)
    try:
        with gzip.open(path, "rt", encoding="utf-8-sig") as file:
            text = file.read(LARGEST)
    except FileNotFoundError:
        raise
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} is no text that gzip has packed: {error}") from None
    if len(text) == LARGEST:
        raise ValueError(f"{path} unpacks to more than {LARGEST} letters")
    return text


def markdown(heads: Iterable, rows: Iterable[Iterable]) -> list[str]:
    """A table in Markdown, line by line."""
    head, *lines = (f"| {' | '.join(map(str, cells))} |" for cells in (heads, *rows))
    return [head, "|---" * len(tuple(heads)) + "|", *lines]


@contextmanager
def shallow(source: object) -> Iterator[None]:
    """Within it, what is nested deeper than Python can follow raises ValueError with its place."""
    try:
        yield
    except (RecursionError, MemoryError):  # Python's parser reports the latter
        raise ValueError(f"{source} is nested too deep, or too long") from None


def document_of(
    text: str | bytes, source: object, kind: type = dict, hook: Callable | None = None
) -> dict | list:
    """A JSON document: an object, or an array where `kind` is list. hook: makes the objects in it.

    Raises ValueError with the place for what is none.
    """
    try:
        document = json.loads(text, object_hook=hook)
    except RecursionError:
        raise ValueError(f"{source} is no JSON of ours: it is nested too deep") from None
    except ValueError as error:
        raise ValueError(f"{source} is no JSON: {error}") from None
    if not isinstance(document, kind):
        raise ValueError(f"{source} is no JSON {'object' if kind is dict else 'array'}")
    return document


def signed(document: dict, indent: int | None = None) -> str:
    """A JSON object with a checksum of its entries, in a line unless it is indented."""
    return json.dumps(document | {CHECK: _check_of(document)}, indent=indent)


def signed_document(text: str | bytes, source: object) -> dict:
    """The object that `signed` wrote; older texts have no checksum.

    Raises ValueError with the place for what is none, or was changed since.
    """
    document = document_of(text, source)
    check = document.pop(CHECK, None)
    if check is not None and check != _check_of(document):
        raise ValueError(f"{source} is not what was written: its checksum differs")
    return document


def _check_of(document: dict) -> int:
    return zlib.crc32(json.dumps(document).encode())


def check_kinds(document: object, kinds: dict) -> None:
    """Raises ValueError for a document without an entry of these names and kinds."""
    if not isinstance(document, dict):
        raise ValueError(f"it must be a JSON object, got {brief(document)}")
    for name, kind in kinds.items():
        if name not in document:
            raise ValueError(f"it has no {name}")
        value = document[name]
        if not isinstance(value, kind) or isinstance(value, bool) and kind is not bool:
            raise ValueError(f"{name} cannot be {brief(value)}")


def brief(value: object) -> str:
    """A value as JSON in a message."""
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def shortened(message: str) -> str:
    """A message whose long quoted values have their begin and their length only."""

    def brief_of(match: re.Match) -> str:
        text = match[0]
        return text if len(text) <= LONG else f"{text[:SHOWN]}... ({len(text)} letters)"

    return QUOTED.sub(brief_of, message)


def listed(text: str | Iterable[str] | None) -> list[str] | None:
    """The parts of a comma list, where one is given; from Python it may be a list already."""
    if text is not None and not isinstance(text, str):
        return list(text)
    return text and [part.strip() for part in text.split(",") if part.strip()]


def digest(path: Path) -> str:
    """Digest of a file's text."""
    import hashlib

    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
