"""
A law of one's own
==================

A plain function is a contact law. The compiler reads its source and differentiates it
exactly. Here a journal drops into a liner that hardens.
"""

import clearance as cl


@cl.contact
def liner(penetration, penetration_rate, impact_speed, stiffness, hardening, damping):
    """A liner that hardens, with a damper, never pulling [N]."""
    if penetration <= 0.0:
        return 0.0
    force = stiffness * penetration * (1.0 + hardening * penetration**2)
    return max(force + damping * penetration_rate, 0.0)


journal = cl.Body("journal", 0.5, 1e-4)
law = liner(stiffness=1e7, hardening=1e9, damping=60.0)
sizes = {"radius": 0.01, "clearance": 5e-4, "length": 0.02}
scene = cl.Scene(
    cl.ClearanceRevolute(
        cl.ground, journal, name="J", contact=law, eccentricity_rate=(0.05, 0.0), **sizes
    ),
    name="drop",
)
run = cl.simulate(scene, until=0.2)
run.plot.orbit("J")

# %%
run.plot.history("J.contact_force,J.eccentricity_y")
