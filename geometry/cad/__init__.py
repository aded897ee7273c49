"""CAD solids of the device and their surfaces as triangles."""
