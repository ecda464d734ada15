"""`clearance stress`: the stiff and extreme matrix."""

from clearance.commands.common import (
    DONE,
    FAILED,
    make_folder,
    progress_of,
    publish,
)
from clearance.values import checks

OPTIONS = {
    "case CASE ?": "only this case (or: random)",
    "--quick": "a seventh of the matrix, short runs",
    "--workers N": (int, None, "processes (default: one a core)"),
    "-o DIR": "folder for table, picture and HDF5",
}


def run(options) -> int:
    """The stress matrix; exit status 1 if a cell crashed, hung or gave a number that is not
    finite.
    """
    import dataclasses

    from clearance.paper_figures import stress
    from clearance.postprocess import study_pictures

    if options.workers is not None:
        checks.whole("--workers", options.workers, 1)
    make_folder(options)
    with progress_of(options) as shown:
        verdicts = stress.stress(
            options.case,
            quick=options.quick,
            workers=options.workers,
            progress=lambda done, total, name: shown(done / total, name),
        )
    document = {"cells": [dataclasses.asdict(v) for v in verdicts]}
    lines = stress.table(verdicts)
    publish(
        options,
        lines,
        document,
        stress.save,
        study_pictures.stress,
        verdicts,
        "stress",
    )
    return FAILED if any(v.kind == "fault" for v in verdicts) else DONE
