"""The nonlinear magnetic field of the normal actuator."""
