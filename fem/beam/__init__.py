"""Beam elements of the lateral actuator."""
