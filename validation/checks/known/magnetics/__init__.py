"""Magnetic fields and circuits whose answers are known: coils in air, bodies of iron."""
