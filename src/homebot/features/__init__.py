"""Features of a house, one folder each: no module imports one, and each can be taken out (docs/features.md)."""
