"""Where a mesh of the solid must be finer."""
