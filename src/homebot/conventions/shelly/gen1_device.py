"""One Shelly of the first generation: what it said of itself and was heard to publish, and its description. Pure."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import Availability, DeviceAnnounced
from homebot.conventions.payload import clean_text
from homebot.conventions.shelly.gen1_inputs import Presses
from homebot.conventions.shelly.gen1_models import Gen1Model, find_model
from homebot.conventions.shelly.gen1_parts import build_parts
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.conventions.shelly.online import OnlineTopic
from homebot.devices.identity import identifiers

__all__ = ["Gen1Device"]


@dataclass(slots=True)
class Gen1Device:
    """All that one device has published so far.

    Attributes:
        topics: Its topics.
        model: What its name or its announcement says that it is; None where that is not known.
        suffixes: Topics below its own that it was heard on.
        mac: Its hardware address, once it announced itself; likewise the following.
        model_name: Of its maker.
        mode: How it is set up, where it has modes.
        version: Of its firmware.
        address: In the network.
        is_announced: Whether it announced itself.
        is_online: Whether it said that it is online.
        topic: Where it was first known by.
        presses: What it told of each of its inputs, at most 16.
    """

    topics: Gen1Topics
    model: Gen1Model | None
    suffixes: set[str] = field(default_factory=set)
    mac: str = ""
    model_name: str = ""
    mode: str = ""
    version: str = ""
    address: str = ""
    is_announced: bool = False
    is_online: bool = False
    topic: str = ""
    presses: defaultdict[int, Presses] = field(default_factory=lambda: defaultdict(Presses))

    def announce(self, device_id: str, mac: str, announcement: Mapping[str, object]) -> bool:
        """Take what it says of itself; tell whether that differs from what it said before."""
        before = self._announced_facts()
        mode = announcement.get("mode")
        self.mac = mac
        self.model_name = _text(announcement.get("model"), 40)
        self.model = find_model(self.model_name, device_id)
        self.mode = mode if isinstance(mode, str) else ""
        self.version = _text(announcement.get("fw_ver"))
        self.address = _text(announcement.get("ip"))
        return self._announced_facts() != before

    def known(self) -> frozenset[str]:
        """Return the topics that it publishes on: what is sure of its model, and what was heard."""
        model = self.model
        if model is None:
            return frozenset(self.suffixes)
        mode = model.modes.get(self.mode)
        if mode is None:
            return model.topics | self.suffixes
        others = {kind for topics in model.modes.values() for kind in map(_kind, topics)}
        wrong = others - set(map(_kind, mode)) - {"input", "input_event"}
        return model.topics | mode | {suffix for suffix in self.suffixes if _kind(suffix) not in wrong}

    def describe(self, topic: str) -> DeviceAnnounced:
        """Return its description; without parts where it is known by none yet.

        Args:
            topic: Where it told last.
        """
        topics = self.topics
        sleeps = self.model is not None and self.model.sleeps
        declared = (self.mac, topics.name if _HARDWARE_ID.fullmatch(topics.name) else "")
        return DeviceAnnounced(
            key=topics.topic,
            convention="shelly",
            native=True,
            whole_device=True,
            identifiers=identifiers(declared),
            name=clean_text(topics.name),
            parts=build_parts(topics, self.model, self.known(), self.presses),
            topic=self.topic or topic,
            facts=self._facts(),
            availability=None if sleeps else Availability((OnlineTopic(topics.at("online")),)),
            owns=(topics.topic,),
            implies_alive=True,
        )

    def _announced_facts(self) -> tuple[str, ...]:
        return self.model_name, self.mode, self.mac, self.version, self.address

    def _facts(self) -> dict[str, str]:
        facts = {
            "manufacturer": "Shelly",
            "model": self.model_name or (self.model.name if self.model is not None else ""),
            "sw_version": self.version,
            "ip_address": self.address,
            "mode": clean_text(self.mode, 20),
        }
        return {name: value for name, value in facts.items() if value}


_HARDWARE_ID = re.compile(r"shelly[a-z0-9-]*-(?:[0-9a-f]{6}|[0-9a-f]{12})", re.IGNORECASE)


def _kind(suffix: str) -> str:
    return suffix.partition("/")[0]


def _text(value: object, limit: int = 120) -> str:
    return clean_text(value, limit) if isinstance(value, str) else ""
