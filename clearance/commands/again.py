"""`clearance run FILE.h5 --again`: a result made again from its own file."""

import math
from pathlib import Path

from clearance.commands.common import of_command

#: options that come from the file
OF_THE_FILE = (
    "parameters turns until rtol error method max_step samples_per_turn channels pressure_fields "
    "compression settle start steady"
)

OPTIONS = {
    "--again": "CASE is a result file, or the folder of a fit: run it again, from the scene and "
    "the options in it"
}


def scene_of(options):
    """A case, the parameters and the scene of a result file.

    Raises ValueError for options that the file has, and where the run cannot be made again.
    """
    from clearance.run.again import again
    from clearance.scene.case import Case, Parameter

    for name in OF_THE_FILE.split():
        if getattr(options, name) != options.usual(name):
            word = "-p" if name == "parameters" else f"--{name.replace('_', '-')}"
            raise ValueError(f"{word} beside --again: the file {options.case} has it; leave it out")
    if (held := Path(options.case) / "run.h5").is_file():  # in the folder of a fit
        options.case = str(held)
    scene, options.of_file = again(options.case)
    of_command(scene, options)
    options.rtol, options.settle = options.of_file["rtol"], options.of_file.get("settle")
    values = dict(scene.parameters)
    parameters = {n: Parameter(n, type(v), v, "?", "") for n, v in values.items()}
    return Case(scene.name, Path(options.case), lambda: scene, "", parameters), values, scene


def output(options) -> Path:
    """The result file. Raises ValueError where it is the one that is made again."""
    path = Path(options.case)
    new = Path(options.output or path.with_name(f"{path.stem}_again{path.suffix}").name)
    if new.resolve() == path.resolve():
        raise ValueError(f"-o {new} is the file that is run again; give another name")
    return new


def compared(path: str, result) -> dict:
    """Differences between a result and the file that it was made from, in words."""
    from clearance.results.result import open_result
    from clearance.run.again import differences, versions

    before = open_result(path)
    apart, one, two = differences(before, result), versions(before), versions(result)
    changed = [f"{n[8:]} {one[n]}, here {two.get(n)}" for n in one if one[n] != two.get(n)]
    name = Path(path).name
    if not apart:
        sentence = f"every number is that of {name}, to the last bit"
    else:
        worst = max(apart, key=apart.get)
        size = f"by {apart[worst]:.2g} of the largest value" if apart[worst] < math.inf else ""
        sentence = f"{len(apart)} columns differ from {name}, {worst} most {size}".rstrip()
    if changed:
        sentence += f"; versions differ: {', '.join(changed)}"
    return {"file": path, "same": not apart, "versions": changed, "sentence": sentence}
