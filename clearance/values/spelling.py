"""One quantity in two spellings: joints/B/force_max, as channels and extremes have it, and
joint_B_force_max, as columns of tables have it. Either stands wherever a name is expected. Parts
of a thing by several names.
"""

from collections.abc import Container, Mapping

from clearance.values.checks import meant

#: how names of columns begin, by the group of a path
GROUPS = {"joints": "joint_", "drives": "drive_", "bodies": ""}


def taken(thing: object, names: str) -> dict[str, object]:
    """Attributes of a thing by their names, with blanks between these."""
    return {name: getattr(thing, name) for name in names.split()}


def as_column(name: str) -> str:
    """The name of a column for the path of a quantity; any other name as it is."""
    group, _, rest = name.strip("/").partition("/")
    return GROUPS[group] + rest.replace("/", "_") if rest and group in GROUPS else name


def as_path(name: str, scene: Mapping) -> str:
    """The path of a quantity for the name of a column; any other name as it is.

    scene: as plain data, whose joints and drives may be meant; the longest name that fits is.
    """
    if "/" in name:
        return name
    parts = {"joints": scene.get("joints", ()), "drives": scene.get("loads", ())}
    for group, elements in parts.items():
        names = sorted((str(e.get("name")) for e in elements), key=len, reverse=True)
        for element in names:
            begin = f"{GROUPS[group]}{element}_"
            if name.startswith(begin):
                return f"{group}/{element}/{name.removeprefix(begin)}"
    return name


def alike(name: str, names: Container[str]) -> str:
    """The spelling of a name that is among others; the name as it is where none is."""
    return name if name in names else as_column(name)


class ByName(dict):
    """Values by names of columns, for paths as well."""

    def __missing__(self, name: str):
        if isinstance(name, str) and dict.__contains__(self, column := as_column(name)):
            return self[column]
        raise KeyError(f"{name}{meant(as_column(str(name)), self)}")

    def __contains__(self, name: object) -> bool:
        return dict.__contains__(self, as_column(name) if isinstance(name, str) else name)

    def get(self, name: str, default=None):
        """The value of a name, else the default."""
        return super().get(as_column(name), default)
