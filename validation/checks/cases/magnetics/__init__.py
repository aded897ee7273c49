"""Magnetic fields and circuits whose answers are known: the cases, and the answers.

The tests, the checks of the report, the stress run and the benchmark share them.
"""
