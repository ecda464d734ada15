"""
Chain of three loops
====================

Friction in all ten pins of a closed chain. The kernel solves reactions and friction
together.
"""

import clearance as cl

run = cl.inverse_dynamics(cl.load_case("three_loop_chain", where="all"), until=10.0)
run.plot.sketch()

# %%
run.plot.friction()
