"""Identification of the device in view among several: each changes in a code of its own, and a sensor looks."""
