"""Devices, values and the journal in the form for people and external programs, from messages in JSON. Pure."""
