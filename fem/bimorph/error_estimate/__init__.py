"""What a mesh of the solid misses: estimates from the residual, and which elements are to blame."""
