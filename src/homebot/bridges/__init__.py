"""Bridges to other systems; each sub-package speaks one foreign protocol."""
