"""
A joint between full film and contact
=====================================

The six-bar rocking feeder at 300 rpm, with a fuzzy transition in joint B. The film
carries most of the turn; the solids carry where the load turns round.
"""

import clearance as cl

run = cl.simulate(cl.load_case("six_bar_feeder", model="mixed", speed=cl.rpm(300)), turns=4)
run.plot.orbit("B")

# %%
# Shares of the time, from the memberships of the states:

for name in ("share_full_film", "share_mixed", "share_dry"):
    print(f"{name:16} {run.facts('joints/B')[name]:.3f}")
