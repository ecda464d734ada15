"""Periodic motion: solved for, its stability, and how it changes with a parameter."""
