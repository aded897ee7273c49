"""Sizes of the normal actuator that the paper does not give, found from what it says."""
