"""The link to a gateway of another machine: its news, and calls of its services."""

from __future__ import annotations

import secrets
from contextlib import suppress
from itertools import count
from typing import TYPE_CHECKING

import anyio

from homebot.errors import LinkError, UnansweredError, UsageError
from homebot.features.machine.messages import (
    MAX_QUIET,
    MAX_SILENCE_S,
    CallGateway,
    CallGatewayRequest,
    FollowGateway,
    FollowGatewayRequest,
    FollowGatewayResponse,
    GetGateways,
    GetGatewaysRequest,
    machine_name,
)
from homebot.messages.cdr import message_to_cdr

if TYPE_CHECKING:
    from homebot.clock import Clock
    from homebot.features.machine.wire import MachineWire
    from homebot.messages.message import Message


class MachineLink:
    """The link to *gateway* of *machine*; an empty name is that of its only one.

    Attributes:
        session: The session that it uses.
        later: Seconds by which the monotonic clock of the machine is behind the one here, or a little less.
        gaps: How often news were missing, so that everything came again.
    """

    def __init__(self, wire: MachineWire, clock: Clock, home: str, machine: str, gateway: str) -> None:
        self.session = wire.session
        self._wire, self._clock = wire, clock
        self._home, self._machine, self._gateway = home, machine, gateway
        self._follower, self._session, self._number = "", "", 0
        self._earlier: set[str] = set()  # sessions of machines that were started anew since
        self._ids = count()
        self._lost_at = 0.0  # when the link counts as lost if no news come until then
        self._calls: set[anyio.CancelScope] = set()
        self.later = 0.0
        self.gaps = 0

    async def join(self) -> None:
        """Begin to follow the gateway.

        Raises:
            LinkError: The machine does not answer.
            PeerError: It refuses, or has not the same secret.
            UsageError: The gateway is to be named.
        """
        if not self._gateway:
            name = machine_name(self._home, self._machine, "gateways")
            names = (await self._wire.ask(name, GetGateways, GetGatewaysRequest(), MAX_SILENCE_S - MAX_QUIET)).names
            if len(names) != 1:
                has = (
                    f"its machine has the gateways {', '.join(names)}; name"
                    if names
                    else "its machine has no gateways yet; add one, and name"
                )
                raise UsageError(f'{has} it here, as in gateway = "mqtt", and each in a table of its own')
            self._gateway = names[0]
        self._follower, self._number = secrets.token_hex(8), 0

    async def news(self) -> FollowGatewayResponse:
        """Return the next news.

        Raises:
            LinkError, PeerError: As :meth:`join`.
            UsageError: A second machine has the same name.
        """
        asked = FollowGatewayRequest(follower=self._follower, number=self._number)
        self._lost_at = self._clock.monotonic() + MAX_SILENCE_S
        news = await self._wire.ask(self._name("follow"), FollowGateway, asked, MAX_SILENCE_S)
        if self._number and news.is_whole:
            self.gaps += 1
        if news.session in self._earlier:
            self._earlier.clear()
            raise UsageError(
                f"two machines answer as {self._machine}; stop one, or give it a name: homebot join --new NAME"
            )
        if news.session != self._session:
            self._earlier.add(self._session)
        self._number, self._session = news.number, news.session
        self.later = self._clock.monotonic() - news.now
        return news

    async def call(self, service: str, request: Message, within: float, longest: float) -> bytes:
        """Return the response, in CDR, of a service of the gateway, the last part of whose name is *service*.

        Args:
            within: Seconds after which the machine is not to carry it out any more.
            longest: Seconds to wait for the response.

        Raises:
            UnansweredError: There was no answer; the call may have been carried out.
            LinkError, PeerError: The machine did not carry it out.
        """
        asked = CallGatewayRequest(
            session=self._session,
            follower=self._follower,
            id=next(self._ids),
            # The clock there is ahead of this by the time that the last news took: none is carried out late.
            until=self._clock.monotonic() - self.later + within,
            arrives_by=self._lost_at - self.later,
            longest=longest,
            service=service,
            request=message_to_cdr(request),
        )
        answer = None
        with anyio.CancelScope() as scope, suppress(LinkError):
            self._calls.add(scope)
            try:
                answer = await self._wire.ask(self._name("call"), CallGateway, asked, longest)
            finally:
                self._calls.discard(scope)
        if answer is None:
            raise UnansweredError(f"{self._machine} did not answer; it may have carried it out")
        if not answer.success:
            why = f"{self._machine}: {answer.message}"
            raise UnansweredError(why) if answer.is_unanswered else LinkError(why)
        return answer.response

    def on_loss(self) -> None:
        """End all calls: their answers are lost."""
        for scope in self._calls:
            scope.cancel()

    def close(self) -> None:
        """Leave the wire."""
        self._wire.close()

    def _name(self, service: str) -> str:
        return machine_name(self._home, self._machine, self._gateway, service)
