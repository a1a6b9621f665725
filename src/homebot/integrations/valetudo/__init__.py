"""valetudo."""
