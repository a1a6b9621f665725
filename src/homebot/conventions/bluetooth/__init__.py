"""Broadcasts of Bluetooth Low Energy devices, and the frames of those that are connected to. Pure."""
