"""The conventions: what makers' devices publish and take. Pure."""
