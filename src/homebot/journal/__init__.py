"""The journal of the house: its notes, how repetitions are folded, and where they are stored."""
