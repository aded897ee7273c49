"""Cases with known answers."""
