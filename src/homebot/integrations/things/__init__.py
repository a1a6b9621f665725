"""things."""
