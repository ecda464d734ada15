"""
Cam and its spring
==================

A follower moves as its cam prescribes: a modified sine up and down. A spring presses it
down. Where the force of the cam would pull, the follower leaves it.
"""

import math

import numpy as np

import clearance as cl


@cl.signal
def lift(time, height, speed):
    """Height of the follower [m]: a rise and a return of half a turn each, without a jerk."""
    angle = speed * time
    return height * (0.5 - 0.5 * math.cos(angle)) ** 2


def turned(speed, stiffness=3e3):
    """A turn, and the least force of the cam [N]; where it is negative the cam would pull."""
    follower = cl.Body("follower", 0.4, 1e-4, points={"foot": (0, 0), "head": (0, 0.08)})
    slide = cl.Prismatic(cl.ground, follower["foot"], axis=(0, 1), name="guide")
    scene = cl.Scene(
        slide,
        cl.SpringDamper(
            cl.ground.at(0, 0.16), follower["head"], stiffness=stiffness, free_length=0.09
        ),
        cl.Drive(slide, motion=lift(height=0.02, speed=speed), name="cam"),
        name="cam",
    )
    run = cl.inverse_dynamics(scene, time=np.linspace(0, 2 * np.pi / speed, 400))
    return run, run.drive("cam").force.min()


run, force = turned(cl.rpm(600))
run.plot.sketch()

# %%
run.plot.history("cam.force,follower.y")

# %%
# From some speed on the follower jumps:

for n in (600, 900, 1000, 1100):
    force = turned(cl.rpm(n))[1]
    print(f"{n:5} rpm: least force {force:7.1f} N", "jumps" if force < 0.0 else "")
