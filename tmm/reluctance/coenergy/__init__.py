"""The co-energy map W'(i, g): what every model of the normal actuator gives."""
