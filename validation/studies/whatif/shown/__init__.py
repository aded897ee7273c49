"""A study as table, files and pictures."""
