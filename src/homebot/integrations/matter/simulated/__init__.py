"""A simulated Matter server, with the nodes that it has commissioned and the devices behind their bridge."""

from homebot.integrations.matter.simulated.node import BridgedMatterDevice, ServedMatterNode
from homebot.integrations.matter.simulated.server import SimulatedMatterServer

__all__ = ["BridgedMatterDevice", "ServedMatterNode", "SimulatedMatterServer"]
