"""Tests of ball-joint friction: models, records, estimation."""
