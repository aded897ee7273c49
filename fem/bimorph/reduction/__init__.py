"""The solid reduced to its ports, as a small system and as a file."""
