"""Scene files to begin with, one a mechanism."""

from pathlib import Path

FOLDER = Path(__file__).parent
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def text_of(name: str) -> str:
    """The text of a scene file, by the name of its mechanism."""
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
