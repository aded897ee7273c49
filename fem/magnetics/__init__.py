"""Magnetostatic fields: half section by u = A_φ / r, three dimensions by A and by φ."""
