"""The faults that a test can cause, with awaitable or blocking methods."""

from typing import final

from homebot.errors import UsageError
from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topics import validate_filter
from homebot.testing.mqtt.core import BrokerCore
from homebot.testing.mqtt.faults import Fault, FaultKind
from homebot.testing.mqtt.thread import BrokerThread


class _Rules:
    """The faults that are rules, caused and lifted without waiting."""

    def __init__(self, core: BrokerCore, thread: BrokerThread) -> None:
        self._core = core
        self._thread = thread

    def drop_acks(self, client: str | None = None) -> Fault:
        """Drop PUBACK, PUBREC and PUBCOMP to the client (None: to all clients)."""
        return self._core.rules.add(Fault(FaultKind.DROPPED_ACKS, client))

    def delay_acks(self, seconds: float, client: str | None = None) -> Fault:
        """Delay PUBACK, PUBREC and PUBCOMP by *seconds*.

        Raises:
            UsageError: *seconds* is not above 0.
        """
        if not seconds > 0:
            raise UsageError(f"an acknowledgement cannot be {seconds} s late")
        return self._core.rules.add(Fault(FaultKind.DELAYED_ACKS, client, seconds=seconds))

    def half_packet(self, client: str | None = None) -> Fault:
        """Cut the next packet to the client in the middle, and close its connection."""
        return self._core.rules.add(Fault(FaultKind.HALF_PACKET, client))

    def slow_reader(self, client: str | None = None) -> Fault:
        """Let the client read nothing until the fault is lifted; then it gets everything that waited."""
        return self._core.rules.add(Fault(FaultKind.SLOW_READER, client))

    def refuse_subscribe(
        self,
        filter: str,  # noqa: A002 - the protocol's own word
        client: str | None = None,
        reason: ReasonCode = ReasonCode.NOT_AUTHORIZED,
    ) -> Fault:
        """Answer subscriptions to exactly this filter with *reason*.

        Raises:
            UsageError: *reason* is no failure, or the filter is not valid.
        """
        return self._refuse(FaultKind.REFUSED_SUBSCRIBE, client, filter, reason)

    def refuse_publish(
        self,
        filter: str,  # noqa: A002 - the protocol's own word
        client: str | None = None,
        reason: ReasonCode = ReasonCode.NOT_AUTHORIZED,
    ) -> Fault:
        """Do not forward messages on matching topics; answer with *reason*, before MQTT 5 with success.

        Raises:
            UsageError: *reason* is no failure, or the filter is not valid.
        """
        return self._refuse(FaultKind.REFUSED_PUBLISH, client, filter, reason)

    def lift_all(self) -> None:
        """End every fault."""
        self._core.rules.lift_all()

    def _refuse(self, kind: FaultKind, client: str | None, filter: str, reason: ReasonCode) -> Fault:  # noqa: A002 - as above
        validate_filter(filter)
        if not reason.failed:
            raise UsageError(f"0x{reason:02x} ({reason.text}) refuses nothing")
        return self._core.rules.add(Fault(kind, client, filter=filter, reason=reason))


@final
class Faults(_Rules):
    """The faults that a test can cause. Rules hold until lifted or their ``with`` ends; the others act at once."""

    async def drop_connection(self, client: str) -> None:
        """Close the client's connection without a DISCONNECT; its will is published.

        Raises:
            UsageError: It is not connected.
        """
        await self._thread.run(self._core.drop, client)

    async def disconnect(self, client: str, reason: ReasonCode = ReasonCode.ADMINISTRATIVE_ACTION) -> None:
        """Disconnect the client; with MQTT 5 it gets *reason*.

        Raises:
            UsageError: It is not connected.
        """
        await self._thread.run(self._core.disconnect, client, reason)

    async def take_over(self, client: str) -> None:
        """Disconnect the client as if another one had connected with its id (0x8E).

        Raises:
            UsageError: It is not connected.
        """
        await self.disconnect(client, ReasonCode.SESSION_TAKEN_OVER)


@final
class BlockingFaults(_Rules):
    """:class:`Faults` for tests without an event loop."""

    def drop_connection(self, client: str) -> None:
        """Close it like :meth:`Faults.drop_connection`."""
        self._thread.call(self._core.drop, client)

    def disconnect(self, client: str, reason: ReasonCode = ReasonCode.ADMINISTRATIVE_ACTION) -> None:
        """Disconnect it like :meth:`Faults.disconnect`."""
        self._thread.call(self._core.disconnect, client, reason)

    def take_over(self, client: str) -> None:
        """Disconnect it like :meth:`Faults.take_over`."""
        self.disconnect(client, ReasonCode.SESSION_TAKEN_OVER)
