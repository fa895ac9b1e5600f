"""What an explanation costs, in -2 log likelihood: the currency of the whole engine.

A piece costs its chi squared and a price, which stands for all that has to be said to describe it
(minimum description length). Settled on simulated rooms and offices (`benchmarks/suites.py`, the
seeds for tuning) and looked at on real logs (`benchmarks/repeatability.py`).
"""

PRICE = 24.0  # of a wall: two parameters, one change point, and the chance of four strays in line
RETURN_PRICE = 20.0  # of a piece more of a wall that is known
ARC_PRICE = 21.0  # of a round object, which stands alone: it has a jump on either side
STRAY_PRICE = 9.0  # of a return that nothing explains
