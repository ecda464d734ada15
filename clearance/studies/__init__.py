"""Contents of compiled scenes, films along runs, and the set of benchmark problems."""
