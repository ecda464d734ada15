"""Functions of a result file: pictures and numbers for people. Nothing here uses the solver."""
