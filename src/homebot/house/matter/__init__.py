"""A simulated Matter server, with the nodes that it has commissioned and the devices behind their bridge."""

from homebot.house.matter.node import BridgedMatterDevice, ServedMatterNode
from homebot.house.matter.server import SimulatedMatterServer

__all__ = ["BridgedMatterDevice", "ServedMatterNode", "SimulatedMatterServer"]
