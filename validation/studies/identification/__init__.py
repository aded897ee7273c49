"""Fitting parameters of a scene to a measured curve, and what the curve cannot tell."""
