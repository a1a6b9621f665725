"""Recordings: the events of a house, line by line, for a replay."""
