"""Queries for devices: their terms, their text form, and matching against devices. Pure."""
