"""matter."""
