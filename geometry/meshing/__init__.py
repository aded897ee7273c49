"""Meshes, their files and checks, and the meshers that know no device."""
