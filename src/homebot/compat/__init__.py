"""Compatibility layer for programs written for other frameworks."""
