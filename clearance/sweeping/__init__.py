"""Sweeps: one structure, many numbers, many processes.

points.py makes the points, definition.py describes a sweep directory, journal.py stores outcomes,
index.py reads them. worker.py runs one point, teams.py hands points to processes or to a cluster,
sweep.py joins all of it.
"""
