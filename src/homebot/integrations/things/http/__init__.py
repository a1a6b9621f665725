"""Devices that W3C Thing Descriptions describe, over any protocol."""
