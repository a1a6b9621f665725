"""The home has a time zone."""

from homebot.clock import read_zone

read_zone("UTC")  # read from the disk before any loop runs
