"""Scene files to begin with, one a mechanism."""

from pathlib import Path

FOLDER = Path(__file__).parent
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def path_of(name: str) -> Path:
    """A scene file, by the name of its mechanism."""
    return FOLDER / f"{name}.toml"
