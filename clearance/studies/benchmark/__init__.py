"""The benchmark set: problems, reference values, the comparison with another code."""
