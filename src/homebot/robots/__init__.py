"""Robots of the house: the position of each, from all available sources."""
