"""Second methods of the benchmark problems, from their pages alone; no code of the package."""
