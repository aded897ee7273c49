"""Bases, quadrature, edge elements, assembly on a fixed pattern: no physics."""
