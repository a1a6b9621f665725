"""Ownership of command topics."""
