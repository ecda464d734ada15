"""`clearance work-precision`: error against run time of solvers, or the price of choices of
physics.
"""

from clearance.commands.common import (
    LENGTH,
    case_options,
    make_folder,
    progress_of,
    publish,
    scene_of,
)

OPTIONS = (
    case_options()
    | LENGTH
    | {
        "--peers": "also numbalsoda, SUNDIALS where installed",
        "--physics": "compare choices of physics instead of solvers",
        "-o DIR": "folder for table, picture and HDF5",
    }
)


def run(options) -> int:
    """Error against run time of solvers, or with --physics the price of choices of physics."""
    from clearance.paper_figures import physics, work_precision
    from clearance.postprocess import study_pictures

    if options.physics and options.peers:
        raise ValueError("--physics compares choices of physics, not solvers: leave out --peers")
    case, values, scene = scene_of(options)
    make_folder(options)
    title = " ".join(
        [
            case.name,
            *(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in values.items()),
        ]
    )
    module = physics if options.physics else work_precision
    if options.physics:
        length = options.turns, options.until
        with progress_of(options) as shown:
            study = physics.compare(case, values, *length, progress=shown)
        draw, stem = study_pictures.physics, "physics"
    else:
        with progress_of(options) as shown:
            study = work_precision.work_precision(
                title,
                scene,
                turns=options.turns,
                until=options.until,
                peers=options.peers,
                progress=shown,
            )
        draw, stem = study_pictures.work_precision, "work_precision"
    lines = [*module.table(study), "", *module.describe(study)]
    return publish(
        options,
        lines,
        module.plain(study),
        module.save,
        draw,
        study,
        stem,
    )
