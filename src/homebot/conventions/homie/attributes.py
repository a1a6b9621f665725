"""Attributes of Homie 3 and 4, each a topic of its own.

Source: Homie convention 4.0.0, "Devices", "Nodes", "Properties".
"""

from __future__ import annotations

__all__ = ["DEVICE_ATTRIBUTES", "NODE_ATTRIBUTES", "PROPERTY_ATTRIBUTES"]

PROPERTY_ATTRIBUTES = ("$name", "$format", "$unit", "$settable", "$retained", "$datatype")
NODE_ATTRIBUTES = ("$name", "$type", "$array", "$properties")
DEVICE_ATTRIBUTES = ("$name", "$mac", "$fw/name", "$fw/version", "$implementation", "$nodes", "$homie", "$state")
