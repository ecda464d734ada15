"""`clearance export`: a case as C source, or as a unit of other people's models."""

import argparse

from clearance.commands.common import DONE, add_case, add_command, json_text, scene_of


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "export")
    add_case(p)
    p.add_argument("--c", metavar="FOLDER", help="write C99 source, with a main that prints a run")
    return p


def run(options) -> int:
    """Write what is requested."""
    from clearance.exporting.export import export

    if options.c is None:
        raise ValueError("export: give --c FOLDER")
    _, values, scene = scene_of(options)
    exported = export(scene, c=options.c)
    model = exported.model
    document = {
        "parameters_given": values,
        "c": str(exported.c),
        "parameters": [n.name for n in model.numbers if not n.is_input],
        "inputs": [n.name for n in model.inputs],
        "outputs": [c.path for c in model.layout.channels],
        "states": model.layout.names,
    }
    if options.json:
        print(json_text(document))
        return DONE
    counts = (f"{len(document[k])} {k}" for k in ("states", "inputs", "parameters", "outputs"))
    print(f"{scene.name}: {', '.join(counts)}")
    print(f"wrote {exported.c}; cc -std=c99 -O2 -ffp-contract=off {exported.c}/*.c -lm")
    return DONE
