"""The contract of gateways as one suite, which runs over every gateway.

A gateway joins by a class of tests derived from :class:`GatewayContract`, with a ``lamp`` of its own, a :class:`Lamp`
in its world of which the test plays the device's side, and a ``gateway`` to that world. The tests run with
pytest-asyncio, with the plug-in of anyio, or with homebot's alone.
"""

from homebot.testing.gateway_contract.command_suite import CommandSuite
from homebot.testing.gateway_contract.device_suite import DeviceSuite
from homebot.testing.gateway_contract.lamp import Lamp, Neighbour
from homebot.testing.gateway_contract.message_suite import MessageSuite
from homebot.testing.gateway_contract.world import running

__all__ = ["GatewayContract", "Lamp", "Neighbour", "running"]


class GatewayContract(DeviceSuite, CommandSuite, MessageSuite):
    """The duties of every gateway."""
