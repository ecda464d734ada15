"""Inverse dynamics: prescribed motion in, efforts of drives, joint reactions and joint friction
out.
"""
