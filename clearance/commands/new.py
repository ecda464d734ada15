"""`clearance new`: a scene file to begin with, or a Python case."""

from pathlib import Path

from clearance.commands.common import scene_of, show
from clearance.scene import templates
from clearance.values.checks import meant

OPTIONS = {
    "case MECHANISM": f"one of {', '.join(templates.NAMES)}; else a case or a result file, "
    "whose numbers the file then has; with --python also your scene file",
    "-p NAME=VALUE ...": "a parameter of a case",
    "--python": "write the same scene as a Python case",
    "-o FILE": "the file (default MECHANISM.toml)",
}


def run(options) -> int:
    """Write the file, never over another one."""
    suffix = ".py" if options.python else ".toml"
    path = Path(options.output or f"{Path(options.case).stem}{suffix}")
    if path.suffix != suffix:
        kind = "Python case" if options.python else "scene file"
        raise ValueError(f"-o {path}: the name of a {kind} ends in {suffix}")
    if path.exists():
        raise ValueError(f"{path} is there already; give another name by -o")
    written = _python if options.python else _toml
    path.write_text(written(options, path.parent), encoding="utf-8")
    sentence = f"wrote {path}; clearance run {path} runs it"
    return show(options, {"file": str(path)}, [sentence])


def _template(options) -> Path | None:
    """The scene file of a mechanism by name.

    Raises ValueError for parameters, which it has inside.
    """
    if options.case not in templates.NAMES:
        return None
    if options.parameters:
        raise ValueError(f"-p: {options.case}.toml has its parameters; give them to run")
    return templates.path_of(options.case)


def _python(options, folder: Path) -> str:
    """The Python case of a scene file. Raises ValueError where there is none."""
    from clearance.scene.write_python import python_of

    source = _template(options) or Path(options.case)
    if source.suffix != ".toml" or not source.is_file():
        answer = f"{meant(options.case, templates.NAMES)}; known: {', '.join(templates.NAMES)}"
        raise ValueError(
            f"--python needs a mechanism or a scene file, got {options.case!r}{answer}"
        )
    return python_of(source, folder)


def _toml(options, folder: Path) -> str:
    """The text of the scene file."""
    if template := _template(options):
        return template.read_text(encoding="utf-8")
    from clearance.scene.catalogue import case_names
    from clearance.scene.write_toml import toml_of

    if options.case.endswith(".h5"):
        from clearance.results.result import open_result
        from clearance.scene.scene import Scene

        if options.parameters:
            raise ValueError(f"-p: {options.case} is a result, whose numbers are given")
        with open_result(options.case) as result:
            sources = result.reader.document("", "scene").get("sources")
            if sources:  # their texts would be run
                names = ", ".join(sorted(Path(text["file"]).name for text in sources.values()))
                hint = (
                    f"write its case instead, clearance new CASE.py, or run {options.case} --again"
                )
                raise ValueError(f"laws of {names} in a result are not run by new; {hint}")
            return toml_of(Scene.from_json(result.reader.attribute("", "scene")), folder=folder)
    suffixed = Path(options.case).suffix or len(Path(options.case).parts) > 1
    if not suffixed and options.case not in case_names():
        names = (*templates.NAMES, *case_names())
        answer = f"{meant(options.case, names)}; one of {', '.join(dict.fromkeys(names))}"
        raise ValueError(f"unknown mechanism {options.case!r}{answer}, or give a path to a file")
    case, _, scene = scene_of(options)
    return toml_of(scene, case.summary, folder)
