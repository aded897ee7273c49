"""Scenes, plans, cross-checks, reports, pictures and the command line.

The only package that may import all others.
"""
