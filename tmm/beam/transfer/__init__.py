"""Timoshenko's beam over frequency, exact to rounding."""
