"""Array of generators coupled through board and skin."""
