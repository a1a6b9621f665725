"""Replays: a recorded day again, with the same or changed apps, in virtual time and with muted gateways."""
