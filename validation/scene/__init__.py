"""Scene files: what is studied and what is wanted of it, checked and in SI units."""
