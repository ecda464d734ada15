"""Checks of input, units, kinds of spots, and numbers that carry many values at once."""
