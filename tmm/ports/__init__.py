"""Ports, and the algebra that joins and terminates what has them."""
