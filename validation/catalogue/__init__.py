"""What can be asked for: quantities and models by name."""
