"""The device and the neighbour with which a gateway takes the contract suite: the author of the gateway writes them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from homebot.devices.value import PlainValue
from homebot.gateways import Gateway


class Lamp(ABC):
    """A lamp that can be turned on and off, in the world of a gateway: its broker, its folder, its radio.

    A protocol without lamps has something else that is on or off, and says which capability that is.

    Attributes:
        settings: All other capabilities that its part takes, each with a value to set.
        together: The capabilities that its protocol sets in the message of a level.
        gone_within: Seconds after :meth:`withdraw` within which it must be removed, where silence is the only sign.
    """

    gateway: Gateway
    name = "Hall"
    service_type = "light"
    capability = "on_off"
    settings: ClassVar[Mapping[str, PlainValue]] = {}
    together: ClassVar[frozenset[str]] = frozenset()
    gone_within = 20.0

    def __init__(self, key: str, part: str = "", *, address: str) -> None:
        self.key = key
        self.part = part
        self.address = address

    @abstractmethod
    async def announce(self) -> None:
        """Enter the house as :attr:`name`, off."""

    @abstractmethod
    async def report(self, *, on: bool) -> None:
        """Report whether it is on."""

    @abstractmethod
    def raw(self, *, on: bool) -> bytes:
        """Return the raw message by which it does."""

    @abstractmethod
    async def misbehave(self) -> None:
        """Let a stranger send so much that breaks the rules that no gateway should go on reading all of it."""

    @abstractmethod
    async def withdraw(self) -> None:
        """Go out of the house."""

    @abstractmethod
    async def told(self) -> bool | None:
        """Return whether its last command turns it on or off; None without a command.

        A brightness or a colour counts as far as it turns the device on in its protocol.
        """

    async def told_value(self, capability: str) -> PlainValue:
        """Return the last received value of one of its :attr:`settings`, in the unit of the vocabulary, or None.

        A value may be rounded as the device rounds it.
        """
        raise NotImplementedError(f"{type(self).__name__} has the setting {capability}, and no told_value")

    @abstractmethod
    async def lose_link(self) -> None:
        """Take the world away from the gateway, which may not run yet."""

    @abstractmethod
    async def mend_link(self) -> None:
        """Give it back."""

    async def meet_again(self) -> None:  # noqa: B027 - no duty: most networks keep what their devices announced
        """Simulate the reaction of the device to a restart of its gateway."""


class Neighbour(ABC):
    """Another system in the world of a gateway, to which homebot exposes devices."""

    @abstractmethod
    async def seen(self, name: str) -> bool | None:
        """Return whether the device that is called *name* is on; None where it is not seen, or says neither."""

    @abstractmethod
    async def turn(self, name: str, *, on: bool) -> None:
        """Command it to be on or off."""
