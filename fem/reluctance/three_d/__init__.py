"""The field in 3D, by vector and by scalar potential."""
