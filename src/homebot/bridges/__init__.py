"""Bridges to other worlds; each sub-package speaks one foreign protocol."""
