"""Wear of clearance joints over a machine's life: summing it in a run, going on over many turns."""
