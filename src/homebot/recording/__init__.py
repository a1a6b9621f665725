"""Recordings: what happened in a house, line by line, for a replay."""
