"""One run: its options, start, advance, observers, diagnosis, checkpoints."""
