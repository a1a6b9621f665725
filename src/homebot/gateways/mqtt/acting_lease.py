"""The lease by which only the first of several homebots of one home at one broker acts; the others observe.

On every new link a homebot that wants to act asks on ``homebot/acting/HOME``, and acts unless another answers that it
already does. If so, it asks again every few seconds, until no answer comes because the other is gone. A crash leaves
nothing to clean up, and no clocks need to agree. If several ask at the same moment, the smallest id wins.
"""

import secrets
from random import Random
from typing import Literal

import anyio
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from homebot.devices.names import ONLY_OBSERVES
from homebot.errors import HomebotError
from homebot.gateways.base import Gateway
from homebot.log import LogLimit
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import OFFLINE, ConnectionState, LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage

YIELDED = "gateway.another_acts"
RESUMED = "gateway.acts_again"
OTHER_OBSERVES = "gateway.another_observes"
NOT_ASKED = "gateway.lease_not_asked"

ANSWER_WITHIN = 2.0
"""Seconds to wait for the answer of another acting homebot."""

ASK_EVERY = 5.0
"""Seconds until an observing homebot asks again."""

_MAX_CHARACTERS = 1000


class _LeaseMessage(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore", defer_build=True)

    says: Literal["ask", "act"]
    id: str = Field(min_length=1, max_length=64)
    name: str = Field(default="", max_length=200)


class ActingLease:
    """Lets a gateway act while no other homebot does.

    Args:
        gateway: Its :attr:`~Gateway.acts` and the reason are kept up to date.
        home: The home; empty for all homes of the broker.
        name: The name of this homebot in the log of the other, for example the computer's name.
        random: Source of its id; a seeded one makes every run the same.

    Attributes:
        rival: The name of the homebot that acts instead; empty if none does.
        topics: The topics on which homebots talk to each other; their messages go to :meth:`on_message`.
    """

    def __init__(
        self, gateway: Gateway, connection: MqttConnection, home: str, name: str, random: Random | None = None
    ) -> None:
        self._gateway = gateway
        self._connection = connection
        self._home = home
        self._topic = f"homebot/acting/{home or '_'}"
        self.topics = frozenset({self._topic, connection.status_topic})
        self._wants = gateway.acts
        self._id = secrets.token_hex(8) if random is None else f"{random.getrandbits(64):016x}"
        self._name = name[:100]
        self._limit = LogLimit(gateway.node.graph.clock)
        self._sure_of: ConnectionState | None = None
        self._is_candidate = False
        self._answer = anyio.Event()
        self._restate = anyio.Event()
        self._doubt = anyio.Event()
        self.rival = ""

    @property
    def trouble(self) -> str:
        """Problem as text; empty if there is none."""
        if not self.rival:
            return ""
        where = f"home {self._home}" if self._home else "this broker"
        return (
            f"another homebot ({self.rival}) already sends commands to {where}; "
            "stop one of the two, or set act = false here"
        )

    def on_message(self, message: MqttMessage) -> None:
        """Handle a lease message of another homebot; retained ones are ignored."""
        if message.retain or len(message.payload) > _MAX_CHARACTERS:
            return
        if message.topic == self._connection.status_topic:
            if message.payload == OFFLINE:  # the will of another homebot of the same name
                self._restate.set()
            return
        try:
            word = _LeaseMessage.model_validate_json(message.payload)
        except ValidationError:
            return
        if word.id != self._id and self._wants:
            self._on_other(word)

    def _on_other(self, word: _LeaseMessage) -> None:
        is_first = self._id < word.id
        if word.says == "act" and not (self._is_sure and is_first):
            self._is_candidate, self._sure_of = False, None
            self._doubt.set()
            self._yield_to(word)
        elif self._is_sure or (self._is_candidate and is_first):
            self._answer.set()
            if word.says == "ask" and self._is_sure:
                self._warn(
                    OTHER_OBSERVES, f"another homebot ({word.name or word.id}) started here as well; it only observes"
                )
        elif self._is_candidate:  # it may have missed our question, so it would not know of us
            self._is_candidate = False
            self._yield_to(word)

    async def serve(self) -> None:
        """Ask, answer, and repeat the online message, until cancelled."""
        topics = [self._topic] if self._wants else []
        if self._connection.status_topic is not None:
            topics.append(self._connection.status_topic)
        try:
            await self._connection.subscribe(*(MqttSubscription(topic, qos=1, no_local=True) for topic in topics))
        except HomebotError as exc:
            self._warn(NOT_ASKED, f"cannot check on {self._topic} whether another homebot sends commands: {exc}")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._restate_status)
            if self._wants:
                tasks.start_soon(self._answer_others)
                tasks.start_soon(self._doubt_on_each_link)
                tasks.start_soon(self._ask_in_doubt)

    @property
    def _is_sure(self) -> bool:
        """True if no answer came on this link; while the last one was down, another homebot may have begun to act."""
        return self._sure_of is not None and self._sure_of is self._connection.state

    async def _doubt_on_each_link(self) -> None:
        async for _ in self._connection.states():
            self._doubt.set()

    async def _ask_in_doubt(self) -> None:
        """Ask until no other answers; who is sure, on a link that stays, wakes the computer for nothing."""
        while True:
            await self._doubt.wait()
            self._doubt = anyio.Event()
            while not self._is_sure and (state := self._connection.state).phase is LinkPhase.CONNECTED:
                self._is_candidate = True
                await self._say("ask")
                await anyio.sleep(ANSWER_WITHIN)
                if self._is_candidate and self._connection.state is state:
                    self._resume()
                    self._sure_of = state
                self._is_candidate = False
                await anyio.sleep(ASK_EVERY)

    async def _answer_others(self) -> None:
        while True:
            await self._answer.wait()
            self._answer = anyio.Event()
            if self._is_sure or self._is_candidate:
                await self._say("act")

    async def _restate_status(self) -> None:
        while True:
            await self._restate.wait()
            self._restate = anyio.Event()
            await self._connection.announce_online()

    async def _say(self, says: Literal["ask", "act"]) -> None:
        word = _LeaseMessage(says=says, id=self._id, name=self._name)
        try:
            await self._connection.publish(self._topic, word.model_dump_json().encode(), qos=1)
        except HomebotError as exc:
            self._warn(NOT_ASKED, f"cannot check on {self._topic} whether another homebot sends commands: {exc}")

    def _yield_to(self, word: _LeaseMessage) -> None:
        is_new = not self.rival
        self.rival = word.name or word.id
        if is_new:
            self._gateway.acts, self._gateway.observes_because = False, self.trouble
            self._gateway.publish_state("active", self.trouble)
            self._gateway.node.log.warning(YIELDED, message=f"only observing: {self.trouble}", rival=self.rival)

    def _resume(self) -> None:
        if not self.rival:
            return
        rival, self.rival = self.rival, ""
        self._gateway.acts, self._gateway.observes_because = True, ONLY_OBSERVES
        self._gateway.publish_state("active")
        self._gateway.node.log.info(
            RESUMED, message=f"sending commands again: the homebot {rival} has stopped", rival=rival
        )

    def _warn(self, event: str, message: str) -> None:
        if self._limit.allows(event) is not None:
            self._gateway.node.log.warning(event, message=message)
