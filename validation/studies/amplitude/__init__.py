"""Large amplitudes: how the head's contact bends resonances, and what is left of deflections."""
