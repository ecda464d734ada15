"""`clearance explain`: what a compiled scene contains, and what was left out."""

from clearance.commands.common import (
    case_options,
    folded,
    log_to_terminal,
    progress_of,
    scene_of,
    show,
)

OPTIONS = case_options() | {"--cost": "also measure what each part of such a scene costs"}


def run(options) -> int:
    """Build the scene and print what was compiled."""
    from clearance.paper_figures import ablation
    from clearance.studies.explain import explain

    log_to_terminal(options)
    case, values, scene = scene_of(options)
    with progress_of(options) as shown:
        parts = ablation.ablation(scene, options.cost, shown)
    report = {"parameters_given": values, **explain(scene), "cost": ablation.plain(parts)}
    lines = [f"{case.name}: {len(report['bodies'])} bodies, {len(report['states'])} states"]
    lines += [f"  state      {name}" for name in report["states"]]
    for name, joint in report["joints"].items():
        laws = ", ".join(f"{k} {v}" for k, v in joint.items() if k not in ("kind", "reality"))
        text = f": {laws}" if laws else ""
        lines.append(f"  joint {name:<4} {joint['reality']} {joint['kind']}{text}")
    lines += [f"  position   {group['bodies']} {group['solved']}" for group in report["plan"]]
    for role, k in report["kernels"].items():
        calls = f", calls {', '.join(k['calls'])}" if k["calls"] else ""
        lines.append(f"  kernel     {role}: {k['operations']} operations{calls}")
    reason, reasons = report["not_in_lanes"], "; ".join(report["not_exported"])
    way = f"each point by itself: {reason}" if reason else "points side by side, in lanes"
    lines += [
        f"  numbers    {report['parameters']} parameters, {report['derived_parameters']} derived "
        "from them",
        f"  outputs    {len(report['channels'])} channels",
        f"  modules    {len(report['modules'])} imported; --json has their names",
        f"  sweeps     {way}",
        f"  export     {f'impossible: {reasons}' if reasons else 'as C source and as FMU'}",
        f"  left out   {', '.join(report['left_out'])}",
        f"  store      {report['store']}",
        *(f"  warning    {warning}" for warning in report["warnings"]),
    ]
    return show(options, report, [*folded(lines, 13), "", *ablation.table(parts)])
