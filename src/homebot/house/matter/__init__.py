"""A Matter server and the nodes that it has commissioned, simulated."""

from homebot.house.matter.node import ServedMatterNode
from homebot.house.matter.server import SimulatedMatterServer

__all__ = ["ServedMatterNode", "SimulatedMatterServer"]
