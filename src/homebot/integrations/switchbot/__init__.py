"""switchbot."""
