"""Journal: each step of each command, and each change that no command explains."""
