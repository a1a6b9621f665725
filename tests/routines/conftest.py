"""Routines have the time zone of the home."""

from homebot.clock import read_zone

read_zone("UTC")  # read from the disk before any loop runs
