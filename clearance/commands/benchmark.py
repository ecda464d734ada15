"""`clearance benchmark`: problems for any code, with reference values and their errors."""

from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    json_text,
    number,
    progress_of,
)

EXAMPLES = "Their statements are in docs/benchmark."
OPTIONS = {
    "names NAME *": "problems to run, or their numbers (default: list all)",
    "--list": "list the problems",
    "--against CSV": "compare another code's values of one problem; exit status 1 where one is off",
    "--rtol R": (number, None, "tolerance of the motions (1e-11)"),
    "-o CSV": "write the references of one, run nothing",
}


def run(options) -> int:
    """List, run or compare; exit status 1 where another code's values are outside or missing."""
    from clearance.studies.benchmark.problems import PROBLEMS, RTOL, benchmark, named
    from clearance.studies.benchmark.rows import source

    names = [] if options.list else [named(name) for name in options.names]
    if (options.against or options.output) and len(names) != 1:
        raise ValueError("--against and -o need one problem: clearance benchmark NAME")
    if options.against and (options.output or options.rtol is not None):
        raise ValueError("--against runs and writes nothing: leave out -o and --rtol")
    if options.rtol is None:
        options.rtol = RTOL
    answers = []
    for name in [] if options.output else names:
        with progress_of(options) as shown:
            shown(name)
            answers.append(benchmark(name, options.against, rtol=options.rtol))
        if not options.json:
            print(answers[-1])
    if options.output:
        _write(Path(options.output), source(names[0]))
    if options.json:
        listed = {name: problem.text for name, problem in PROBLEMS.items()}
        print(json_text({a.name: a.plain for a in answers} if names else listed))
    elif not names:
        for number, (name, problem) in enumerate(PROBLEMS.items(), 1):
            print(f"{number:2} {name:20} {problem.text}")
    return FAILED if options.against and not answers[0].inside else DONE


def _write(path: Path, text: str) -> None:
    """A file of references, never over another one."""
    if path.exists() and path.read_bytes() != text.encode():
        raise ValueError(f"-o {path} is there already; give another name")
    path.write_text(text, encoding="utf-8")
