"""The models of the lateral actuator, and the bridge between them."""
