"""The discovery layer: an index of the devices in the house, and the node that keeps it."""

from homebot.discovery.directory import Directory, DirectorySettings
from homebot.discovery.index import DeviceIndex
from homebot.discovery.owner_facts import OwnerFacts

__all__ = ["DeviceIndex", "Directory", "DirectorySettings", "OwnerFacts"]
