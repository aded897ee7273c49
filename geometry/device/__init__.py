"""Parameters with their sources, materials, and where every part sits; checks that it all fits."""
