"""The figures that only the report shows."""
