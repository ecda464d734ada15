"""Mechanisms ready to run, one scene per file: a function of the swept quantities; in a folder the
problems of the benchmark set.
"""
