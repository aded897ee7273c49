"""Every model of the scene behind one interface."""
