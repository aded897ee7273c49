"""Steady oscillations of a system with few nonlinear coordinates."""
