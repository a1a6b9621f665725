"""One Shelly of the second generation or later: what it answered, and its description made of that. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import Availability, DeviceAnnounced
from homebot.conventions.payload import clean_text
from homebot.conventions.shelly.gen2_answers import fields_in, mac_in, sleeps, text_of
from homebot.conventions.shelly.gen2_component import Fields, Gen2Topics
from homebot.conventions.shelly.gen2_parts import MAX_COMPONENTS, build_parts
from homebot.conventions.shelly.online import OnlineTopic
from homebot.devices.identity import identifiers
from homebot.devices.part import Part
from homebot.numbers import to_number

__all__ = ["Gen2Device", "looks"]


@dataclass(slots=True)
class Gen2Device:
    """The answers of one device so far.

    Attributes:
        prefix: What its topics begin with.
        info: The answer to ``Shelly.GetDeviceInfo``.
        config: That to ``Shelly.GetConfig``.
        status: That to ``Shelly.GetStatus``, or what it told when it woke; before, what it told of components.
        sizes: Bytes of each answer that is kept.
        signs_of_life: Signs of life before it was described.
        described: Its description as it was given last; None before.
    """

    prefix: str
    info: Fields = field(default_factory=dict)
    config: Fields = field(default_factory=dict)
    status: Fields = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    signs_of_life: int = 0
    described: DeviceAnnounced | None = None

    def keep(self, kind: str, answer: Fields, size: int) -> None:
        """Take an answer of *size* bytes in the place of the last of its *kind*: info, config or status."""
        self.sizes[kind] = size
        match kind:
            case "info":
                self.info = answer
            case "config":
                self.config = answer
            case _:
                self.status = answer

    @property
    def has_status(self) -> bool:
        """True if it told its whole status."""
        return "status" in self.sizes

    def has_new_fields(self, components: Fields) -> bool:
        """Return whether *components* say something of it that is new; its values are not."""
        return any(
            isinstance(fields, dict) and not fields.keys() <= fields_in(self.status, key).keys()
            for key, fields in components.items()
        )

    def learn_components(self, components: Fields, size: int) -> None:
        """Take what it tells of components; *size* is how many bytes of that are kept now."""
        self.sizes["components"] = size
        status = dict(self.status)
        for key, fields in components.items():
            if isinstance(fields, dict) and (key in status or len(status) < MAX_COMPONENTS):
                status[key] = {**fields_in(status, key), **fields}
        self.status = status

    @property
    def mac(self) -> str:
        """Its hardware address; empty where it did not tell it yet."""
        address = text_of(self.info.get("mac")) or text_of(fields_in(self.status, "sys").get("mac"))
        return address or mac_in(self.prefix)

    def describe(self, client: str, topic: str, device_id: str) -> DeviceAnnounced:
        """Return its description; without parts where no component of it is known.

        Args:
            client: As whom homebot asks.
            topic: Where it told last.
            device_id: What it called itself there.
        """
        device_id = text_of(self.info.get("id")) or device_id
        models = f"{device_id} {text_of(self.info.get('app'))}".casefold()
        topics = Gen2Topics(
            self.prefix,
            client,
            f"{client}/{self.prefix}/rpc",
            is_plug=any(name in models for name in _PLUGS),
        )
        return DeviceAnnounced(
            key=self.prefix,
            convention="shelly",
            native=True,
            whole_device=True,
            identifiers=identifiers((self.mac, device_id if device_id.casefold().startswith("shelly") else "")),
            name=self._name(),
            parts=build_parts(topics, self.status, self.config),
            topic=topic if self.described is None else self.described.topic,
            facts=self._facts(),
            availability=None if sleeps(self.status) else Availability((OnlineTopic(f"{self.prefix}/online"),)),
            owns=(self.prefix,),
            implies_alive=True,
        )

    def _name(self) -> str:
        own = text_of(self.info.get("name"))
        return own or text_of(fields_in(fields_in(self.config, "sys"), "device").get("name")) or clean_text(self.prefix)

    def _facts(self) -> dict[str, str]:
        generation = to_number(self.info.get("gen"))
        facts = {
            "manufacturer": "Shelly",
            "model": text_of(self.info.get("model")),
            "model_id": text_of(self.info.get("app")),
            "sw_version": text_of(self.info.get("ver")),
            "generation": "" if generation is None else f"{generation:g}",
        }
        return {name: value for name, value in facts.items() if value}


def looks(described: DeviceAnnounced) -> tuple[tuple[Part, ...], str, Mapping[str, str], tuple[str, ...]]:
    """Return what of a description is news when it differs."""
    return tuple(one.part for one in described.parts), described.name, described.facts, described.identifiers


_PLUGS = ("plug", "pstrip", "powerstrip", "outdoors")
