"""Habits of the people in a house, found in recorded days; each is proposed as a routine, with its proof."""
