"""Sweeps: one structure, many numbers, many processes.

points.py says where, definition.py what a sweep directory holds, journal.py keeps what is done,
index.py reads it, worker.py runs one point, teams.py hands points to processes or to a cluster,
driver.py does it all, metrics.py sums up a run.
"""
