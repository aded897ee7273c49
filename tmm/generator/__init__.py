"""The whole generator: both actuators on one rod, between its spring and its stops."""
