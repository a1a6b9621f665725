"""Devices, values and the journal as people and programs outside read them; of messages as JSON has them. Pure."""
