"""Replays of a recorded day, with the same or changed apps, in virtual time and with muted gateways."""
