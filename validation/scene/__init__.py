"""Scene files, checked and in SI units."""
