"""The topics of one Tasmota device, and its commands. Pure.

Source: tasmota.github.io/docs, MQTT and Commands; hatasmota 0.10.2 for the spelling of commands.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import require_bool
from homebot.conventions.description import Publication, Publications
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings
from homebot.conventions.tasmota.config import TasmotaConfig
from homebot.devices.value import PlainValue

__all__ = ["TasmotaTopics", "power_commands", "sensor_values"]


@dataclass(frozen=True, slots=True)
class TasmotaTopics:
    """The topics of one device, by its announced configuration."""

    config: TasmotaConfig

    def results(self, *commands: str) -> tuple[str, ...]:
        """Return the topics of the answers to *commands*, on which changes are reported too."""
        answers = commands if self.config.option(_COMMAND_TOPICS_OPTION) else ("RESULT",)
        return tuple(f"{self.config.results}{answer.upper()}" for answer in answers)

    def states(self, *commands: str) -> tuple[str, ...]:
        """Return the topics of the states that *commands* change: reported at once, and every few minutes."""
        return (*self.results(*commands, "State"), self.telemetry)

    @property
    def telemetry(self) -> str:
        """The topic on which outputs are reported every few minutes."""
        return f"{self.config.telemetry}STATE"

    @property
    def sensors(self) -> tuple[str, str]:
        """The topics on which sensors are reported: every few minutes, and when requested."""
        return f"{self.config.telemetry}SENSOR", f"{self.config.results}STATUS10"

    @property
    def state_requests(self) -> Publications:
        """Requests of its outputs; none for a sleeping device, which would never receive them."""
        return self._request("STATE", b"")

    @property
    def sensor_requests(self) -> Publications:
        """Requests of its sensors; none for a sleeping device."""
        return self._request("STATUS", b"10")

    def publish(self, command: str, argument: str | int = "") -> Publications:
        """Return the publication of one command."""
        return (Publication(self.topic(command), str(argument).encode()),)

    def publish_all(self, commands: list[tuple[str, str | int]]) -> Publications:
        """Return the publication of several commands, executed together."""
        backlog = ";".join(f"NoDelay;{command} {argument}" for command, argument in commands)
        return (Publication(self.topic("Backlog"), backlog.encode()),)

    def topic(self, command: str) -> str:
        """Return the topic of a command."""
        return f"{self.config.commands}{command}"

    def state_text(self, on: bool) -> str:  # noqa: FBT001 - the only argument
        """Return its text for on or off."""
        return self.config.state_texts[1 if on else 0]

    def add_power_switch(self, part: JsonPart, index: int) -> None:
        """Add ``on_off`` of the output *index*, with a command of its own."""
        for topic in self.states(*power_commands(index)):
            part.read_from(topic, partial(self.read_power, index))
        part.add_capability("on_off", writer=partial(self._switch, index))
        part.add_command_topics(self.topic(f"Power{index + 1}"))
        part.add_state_request(*self.state_requests)

    def add_power_state(self, part: JsonPart, index: int) -> None:
        """Add ``state`` of the output *index*, which cannot be set."""
        for topic in self.states(*power_commands(index)):
            part.read_from(topic, partial(self._read_state, index))
        part.add_capability("state")
        part.add_state_request(*self.state_requests)

    def read_power(self, index: int, message: JsonMessage) -> Readings:
        """Read whether the output *index* is on. A single output has no number."""
        state = message.get(f"POWER{index + 1}", message.get("POWER") if index == 0 else None)
        if not isinstance(state, str) or state not in self.config.state_texts[:2]:
            return NO_READINGS
        return {"on_off": state == self.config.state_texts[1]}

    def _read_state(self, index: int, message: JsonMessage) -> Readings:
        readings = self.read_power(index, message)
        return {"state": readings["on_off"]} if readings else NO_READINGS

    def _switch(self, index: int, value: PlainValue, _transition: float) -> Publications:
        return self.publish(f"Power{index + 1}", self.state_text(require_bool("on_off", value)))

    def _request(self, command: str, argument: bytes) -> Publications:
        return () if self.config.is_sleeper else (Publication(self.topic(command), argument),)


_COMMAND_TOPICS_OPTION = 4
"""SetOption4: the answer to a command has a topic with its name."""


def power_commands(index: int) -> tuple[str, ...]:
    """Return the names by which the output *index* reports its power. A single output has no number."""
    return (f"Power{index + 1}", *(("Power",) if index == 0 else ()))


def sensor_values(message: JsonMessage) -> JsonMessage:
    """Return the sensors in a message: an answer to a request has them in an inner object."""
    inner = message.get("StatusSNS")
    return inner if isinstance(inner, dict) else message
