"""What a cross-section of the row is worth: stiffness, shear, coupling, joints, tapers."""
