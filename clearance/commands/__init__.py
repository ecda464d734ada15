"""One command a file: its options, and what it prints."""

#: names of all commands, with the line that each has in help, in its order
COMMANDS = {
    "cases": "list cases with their parameters, units and defaults",
    "new": "write a scene file of a mechanism, to run and to change",
    "run": "run a case and write an HDF5 result file",
    "explain": "what the compiled scene contains and what was left out",
    "sweep": "a case at many points: resumable, on all cores or a cluster",
    "scatter": "a case whose parameters vary by chance: quantiles, limits, who is to blame",
    "dataset": "labelled records of a case, with the noise of a sensor",
    "wear": "life of a mechanism whose joints wear: stages of turns, and jumps between them",
    "plot": "pictures of run files and sweeps",
    "report": "one HTML file about a run or a sweep, that needs nothing else",
    "view": "a page that moves, of runs or of a sweep, in one HTML file",
    "export": "a case as C source, or as a unit (FMU) of other people's models",
    "inverse": "driving efforts and joint reactions of a prescribed motion, with friction",
    "fit": "parameters of a mechanism from its records, with intervals; or what records would tell",
    "optimize": "dimensions from limits: the best design, what limits cost, the map around it",
    "identify": "parameters of a joint's model from measurements",
    "bench-data": "synthetic test-bench data of a joint's friction, for identify",
    "film": "oil films: pressure fields, force maps, snapshots, mesh and error studies",
    "lyapunov": "largest Lyapunov exponent: whether a motion is chaotic, with its error",
    "follow": "a periodic motion over a parameter: stability, folds, period doublings",
    "work-precision": "error against run time: all methods, with --peers others' too",
    "benchmark": "twelve problems for any code, with reference values, their errors, a comparison",
    "stress": "the stiff and extreme matrix: each cell done or a named reason",
    "figures": "regenerate the figures of the source systems and of the evidence",
}
