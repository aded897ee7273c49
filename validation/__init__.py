"""What people ask: scenes, plans, cross-checks, reports, pictures, the command line.

The only package that may import all others.
"""
