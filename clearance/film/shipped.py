"""The film tables that come with the package: `python -m clearance.film.shipped` makes them again.

A table is requested by its key and by the source of what makes it (see table.Key.name). After a
change of the solver none of these tables is used until they are made again.
"""

from clearance.film import table as tables
from clearance.film.table import Key

#: L/D of bearings: usual ones, among them those of all cases but the slider-crank
USUAL = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
#: L/D of the slider-crank of Flores et al. at its own clearance; a table of its neighbours serves
#: others as well
SLIDER_CRANK = 40.0 / (2.0 * 9.5)


def keys() -> list[Key]:
    """Keys of the tables that come with the package."""
    near = tables.neighbours(1.0, Key(SLIDER_CRANK), "slenderness")
    return [*(Key(slenderness) for slenderness in USUAL), *(key for _, key in near)]


def main() -> None:
    """Build all, and remove what is of an older solver."""
    tables.SHIPPED.mkdir(exist_ok=True)
    files = {tables.SHIPPED / tables.path_of(key).name: key for key in keys()}
    for old in set(tables.SHIPPED.glob("*.npz")) - set(files):
        old.unlink()
    for path, key in files.items():
        tables._write(path, key, key.build())
        print(f"{path.name}: L/D {key.slenderness:g}, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
