"""Contents of compiled scenes; reference values of the benchmark set, beside those of any code."""
