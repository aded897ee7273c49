"""Sparse factorisation, products of rows, Newton: no physics."""
