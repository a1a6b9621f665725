"""WLED: the lights of a controller, their reports and commands. Pure."""
