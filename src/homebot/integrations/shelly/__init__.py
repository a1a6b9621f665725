"""shelly."""
