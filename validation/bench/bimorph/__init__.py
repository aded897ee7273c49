"""The benchmark's rows of the lateral actuator."""
