"""History: measurements and states of devices, kept for years in little space."""
