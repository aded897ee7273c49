"""What-if studies: a scene at many points of its keys, by any model."""
