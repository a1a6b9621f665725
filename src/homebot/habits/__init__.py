"""Habits of the people in a house, found in what was recorded; each is proposed as a routine, with its proof."""
