"""Contents of compiled scenes, and the set of benchmark problems."""
