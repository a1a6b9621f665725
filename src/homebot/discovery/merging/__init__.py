"""Merging of announcements into devices, and of their parts. Pure."""
