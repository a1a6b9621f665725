"""homekit."""
