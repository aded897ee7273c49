"""Many scenes of the axisymmetric field at once: tables over one or two numbers, and walks."""
