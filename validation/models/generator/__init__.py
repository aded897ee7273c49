"""The whole machine on any model of the lateral actuator."""
