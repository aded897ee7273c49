"""The solid reduced over geometry and materials: one small system for a range of bimorphs."""
