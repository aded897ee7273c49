"""The field in the half section."""
