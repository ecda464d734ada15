"""Free parameters of a command line: -p NAME=LOW:HIGH beside -p NAME=VALUE."""

from clearance.commands.common import case_of, of_command
from clearance.values import checks
from clearance.values.units import quantity


def bounded_scene(options) -> tuple:
    """The scene with the parameters that hold; bounds by name, None where a value is missing."""
    from clearance.scene.parameter import varied

    case, values, numbers, bounds = case_of(options), {}, {}, {}
    for item in options.parameters:
        name, equals, text = item.partition("=")
        if name in {*values, *numbers, *bounds}:
            raise ValueError(f"-p {item}: {name} is given twice")
        if not equals or is_range(text):
            bounds[name] = text if equals else None
        elif "/" in name:
            numbers[name] = text
        elif name in case.parameters:
            values |= case.read({name: text}, values)
        else:
            checks.known("the case has no parameter", name, case.parameters)
    scene = case.scene(**values)
    if numbers:
        units = {n: varied(scene, n, 1.0).units for n in numbers}
        scene = scene.replaced({n: quantity(t, units[n]) for n, t in numbers.items()})
    return of_command(scene, options), bounds


def is_range(text: str) -> bool:
    """True for LOW:HIGH."""
    ends = text.split(":")
    if len(ends) != 2:
        return False
    try:
        return all(quantity(end) is not None for end in ends)
    except ValueError:
        return False


def check_bounds(bounds: dict, otherwise: str = "") -> None:
    """Raise ValueError for a parameter without bounds; otherwise: what takes the name alone."""
    if missing := [n for n, b in bounds.items() if b is None]:
        raise ValueError(f"-p {missing[0]}: expected {missing[0]}=LOW:HIGH or a value{otherwise}")
