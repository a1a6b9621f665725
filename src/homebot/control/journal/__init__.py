"""Journal: each step of each command, and the changes that no command explains, as data."""
