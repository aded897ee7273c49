"""Steady oscillations of what is linear but for a few coordinates; knows no device."""
