"""The models of the normal actuator."""
