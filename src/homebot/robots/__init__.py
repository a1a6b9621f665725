"""Robots of the house: where each of them is, from all that is known of it."""
