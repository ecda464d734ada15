"""Fields of the elements of a scene and units of numbers as tables of the guide.

`python docs/fields.py` renews them.
"""

import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import Field, fields
from pathlib import Path

import clearance as cl
from clearance.elements.body import Body
from clearance.laws.law import Family
from clearance.scene.document import KINDS, is_needed
from clearance.scene.toml_scene import SECTIONS
from clearance.values.units import UNITS, ZEROS

#: what a table in a scene file makes, by its section
TABLES = {
    "body": [Body],
    **{section: [KINDS[name] for name in names] for section, names in SECTIONS.items()},
    "lubricant": [cl.Lubricant],
    "material": [cl.Material],
    "a field `heat`": [cl.HeatBalance],
}
#: the key of a table is the name
OMITTED = {"name"}


def table() -> list[str]:
    """A row for each kind: its section, the fields that it needs, and the others."""
    lines = ["| section | kind | needs | may have |", "|---|---|---|---|"]
    for section, kinds in TABLES.items():
        where = section if section.startswith("a ") else f"`[{section}]`"
        for kind in kinds:
            needs, others = [], []
            for field, text in described(kind):
                (needs if is_needed(field) else others).append(text)
            lines.append(
                f"| {where} | `{kind.__name__}` | {'; '.join(needs)} | {'; '.join(others)} |"
            )
    return lines


def described(kind: type) -> Iterator[tuple[Field, str]]:
    """Fields of a kind with their names, meanings and default numbers."""
    hints = typing.get_type_hints(kind)
    for field in fields(kind):
        if field.name not in OMITTED or is_needed(field) and kind is cl.Material:
            meaning = f"{_meaning(field, hints[field.name])}{_default(field)}"
            yield field, f"`{field.name}` {meaning}".replace("|", "\\|").strip()


def _meaning(field: Field, hint: object) -> str:
    """Text of a field with its unit, or the kind of its value."""
    if field.name in OMITTED:
        return "that the key of its table gives"
    number = field.metadata.get("number")
    if number:
        text = number.text.removeprefix(f"{field.name} ")
        return f"{text}, or {_laws(number.families)}" if number.families else text
    if "law" in field.metadata:
        return f"{field.metadata['text']}: {_laws(field.metadata['law'])}"
    if unit := field.metadata.get("unit"):
        return f"[{unit}]"
    kinds = [k for k in typing.get_args(hint) or (hint,) if isinstance(k, type)]
    if typing.get_origin(hint) is Mapping:
        return "by name, each [x, y] [m]"
    if bool in kinds:
        return "true or false"
    if object in kinds:
        return "a `ThermalNode`"
    return "a " + " or ".join(f"`{k.__name__}`" for k in kinds if k is not type(None))


def _laws(families: Iterable[Family]) -> str:
    """Families of laws that a field takes."""
    names = dict.fromkeys(f"`{family.name}`" for family in families)
    return f"a law of {' or '.join(names)}"


def _default(field: Field) -> str:
    value = field.default
    if isinstance(value, bool):
        return f" ({str(value).lower()})"
    if isinstance(value, int | float):
        return f" ({value:g})"
    if isinstance(value, tuple) and value:
        return f" ([{', '.join(f'{v:g}' for v in value)}])"
    return ""


def units() -> list[str]:
    """A row for each SI unit: the other units that are read, and what they are in it."""
    others: dict[str, list[str]] = {}
    for unit, (si, factor) in UNITS.items():
        text = f"`{unit}`" if factor == 1.0 else f"`{unit}` = {factor:.6g}"
        text += f" + {ZEROS[unit]:g}" if unit in ZEROS else ""
        others.setdefault(si, []).append(text)
    rows = [f"| {si} | {', '.join(texts)} |" for si, texts in others.items()]
    return ["| in SI | written as |", "|---|---|", *rows]


def materials() -> list[str]:
    """A row for each material of bearings."""
    heads = "name", "E [GPa]", "nu", "density [kg/m3]", "hardness [MPa]"
    heads += "dry wear on steel [mm3/Nm]", "source"
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for name, row in cl.Material.table().items():
        m = row.material
        wear = " to ".join(f"{k * 1e9:.0e}" for k in row.wear) if row.wear else ""
        numbers = f"{m.young / 1e9:g} | {m.poisson:g} | {m.density:g} | {row.hardness / 1e6:g}"
        lines.append(f"| `{name}` | {numbers} | {wear} | {row.source} |")
    return lines


#: page of each table, by the mark around it
PAGES = {"fields": ("elements.md", table), "units": ("mechanism.md", units)}
PAGES["materials"] = ("wear.md", materials)


def renewed(text: str, mark: str) -> str:
    """The page with the table of this mark."""
    begin, end = f"<!-- {mark} -->", f"<!-- {mark}:end -->"
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(end)
    return "\n".join([f"{head}{begin}", "", *PAGES[mark][1](), "", f"{end}{tail}"])


if __name__ == "__main__":
    for name, (page, _) in PAGES.items():
        path = Path(__file__).parent / page
        path.write_text(renewed(path.read_text(encoding="utf-8"), name), encoding="utf-8")
