"""Entities of Home Assistant by their states, as its WebSocket shows them."""
