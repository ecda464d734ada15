"""`clearance export`: a case as C source, or as a unit of other people's models."""

from clearance.commands.common import (
    case_options,
    log_to_terminal,
    scene_of,
    show,
)

OPTIONS = case_options() | {
    "--fmu FILE.fmu": "write a unit (FMI 3.0)",
    "--c FOLDER": "write C99 source, with a main that prints a run",
    "--page FILE.html": "write a page that computes: sliders move the mechanism",
    "--check": "run the unit by FMPy beside the own run, and print the largest difference",
}


def run(options) -> int:
    """Write what is requested."""
    from clearance.exporting.export import export

    if options.c is options.fmu is options.page is None:
        raise ValueError("export: give --fmu FILE.fmu, --c FOLDER or --page FILE.html")
    if options.check and options.fmu is None:
        raise ValueError("export: --check needs --fmu FILE.fmu")
    log_to_terminal(options)
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
    counts = (f"{len(document[k])} {k}" for k in ("states", "inputs", "parameters", "outputs"))
    lines = [f"{scene.name}: {', '.join(counts)}"]
    if exported.fmu:
        lines.append(f"wrote {exported.fmu}: sources, {_binaries(exported.platforms)}")
    if exported.c:
        compiler = f"cc -std=c99 -O2 -ffp-contract=off {exported.c}/*.c -lm"
        lines.append(f"wrote {exported.c}; {compiler}")
    if options.page:
        lines.append(f"wrote {options.page}")
    for d in differences:
        lines.append(f"{d.kind}: within {d.share:.2g} of the size of {d.name} over {d.until:.6g} s")
    lines += [f"FMPy: {message}" for d in differences[:1] for message in d.messages]
    return show(options, document, lines)


def _binaries(platforms: tuple[str, ...]) -> str:
    if platforms:
        return f"binaries for {', '.join(platforms)}"
    return "no binaries: there is no compiler here; pip install ziglang, or compile it elsewhere"
