"""The bimorph on a head that may rock: responses, backbones, deflections by harmonic balance."""
