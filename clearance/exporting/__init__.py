"""Scenes as parts of other people's models: C source, and functional mock-up units (FMI 3.0)."""
