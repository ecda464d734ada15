"""`clearance export`: a case as C source, or as a unit of other people's models."""

import argparse

from clearance.commands.common import (
    DONE,
    add_case,
    add_command,
    json_text,
    log_to_terminal,
    scene_of,
)


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "export")
    add_case(p)
    p.add_argument("--fmu", metavar="FILE.fmu", help="write a unit (FMI 3.0)")
    p.add_argument("--c", metavar="FOLDER", help="write C99 source, with a main that prints a run")
    p.add_argument(
        "--page", metavar="FILE.html", help="write a page that computes: sliders move the mechanism"
    )
    p.add_argument(
        "--check",
        action="store_true",
        help="run the unit by FMPy beside the own run, and print the largest difference",
    )
    return p


def run(options) -> int:
    """Write what is requested."""
    from clearance.exporting.export import export

    if options.c is options.fmu is options.page is None:
        raise ValueError("export: give --fmu FILE.fmu, --c FOLDER or --page FILE.html")
    if options.check and options.fmu is None:
        raise ValueError("export: --check needs --fmu FILE.fmu")
    if not options.json:
        log_to_terminal()
    _, values, scene = scene_of(options)
    exported = export(scene, c=options.c, fmu=options.fmu, page=options.page)
    model = exported.model
    document = {
        "parameters_given": values,
        "c": exported.c and str(exported.c),
        "fmu": exported.fmu and str(exported.fmu),
        "page": exported.page and str(exported.page),
        "platforms": exported.platforms,
        "parameters": [n.name for n in model.numbers if not n.is_input],
        "inputs": [n.name for n in model.inputs],
        "outputs": [c.path for c in model.layout.channels],
        "states": model.layout.names,
    }
    differences = []
    if options.check:
        from clearance.exporting.check import checked

        differences = checked(model, exported.fmu)
        document["check"] = [vars(d) for d in differences]
    if options.json:
        print(json_text(document))
        return DONE
    counts = (f"{len(document[k])} {k}" for k in ("states", "inputs", "parameters", "outputs"))
    print(f"{scene.name}: {', '.join(counts)}")
    if exported.fmu:
        print(f"wrote {exported.fmu}: sources, {_binaries(exported.platforms)}")
    if exported.c:
        print(f"wrote {exported.c}; cc -std=c99 -O2 -ffp-contract=off {exported.c}/*.c -lm")
    if options.page:
        print(f"wrote {options.page}")
    for d in differences:
        print(f"{d.kind}: within {d.share:.2g} of the size of {d.name} over {d.until:.6g} s")
    for message in differences[0].messages if differences else ():
        print(f"FMPy: {message}")
    return DONE


def _binaries(platforms: tuple[str, ...]) -> str:
    if platforms:
        return f"binaries for {', '.join(platforms)}"
    return "no binaries: there is no compiler here; pip install ziglang, or compile it elsewhere"
