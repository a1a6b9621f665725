"""The commands, one module each; only that of the command that is given is imported."""
