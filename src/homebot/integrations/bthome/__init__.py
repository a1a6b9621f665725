"""bthome."""
