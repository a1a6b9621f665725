"""Simulated devices that are servers of HTTP: real ones, on a port of this computer."""
