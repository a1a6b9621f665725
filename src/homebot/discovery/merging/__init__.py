"""Decides which announcements are about one device, and which parts are one. Pure."""
