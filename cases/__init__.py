"""Mechanisms ready to run, one scene per file: a function of the swept quantities."""
