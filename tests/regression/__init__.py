"""Whole runs of every case against stored results."""
