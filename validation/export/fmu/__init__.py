"""The generator as a unit for co-simulation (FMI 2.0): C sources, and what wraps them."""
