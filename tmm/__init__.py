"""Closed-form, transfer-matrix and lumped models, and the algebra of their ports.

May import geometry's parameters and materials; never :mod:`fem`, whose numbers it is
there to check.
"""
