"""Answers by other ways and other people's codes, which only check ours."""
