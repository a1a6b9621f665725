"""Philips Hue: the resources of a bridge, their values and commands. Pure."""
