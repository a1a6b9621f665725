"""Devices that W3C Thing Descriptions describe, whatever protocol they are used over."""
