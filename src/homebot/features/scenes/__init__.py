"""Scenes: a name, and a value for each of a set of parts; kept by homebot for the owner, or by a bridge or device."""
