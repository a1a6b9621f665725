"""The commands, one module each; only the module of the given command is imported."""
