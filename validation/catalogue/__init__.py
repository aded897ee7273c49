"""Quantities and models by name."""
