"""Conventions: the messages and commands of makers' devices. Pure."""
