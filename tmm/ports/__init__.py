"""Ports, and the algebra that joins and terminates them."""
