"""Groups of a bridge: lamps, switches or covers that one message reaches. Pure.

Source: zigbee2mqtt.io, Usage > Groups; Zigbee2MQTT 2.14.1, ``lib/extension/groups.ts``: it reports the state of a group
for each of its members without having heard from them.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from homebot.conventions.description import Codec, DescribedPart, Publication, Publications, WritesSeveral
from homebot.conventions.payload import as_fields, compact_json, parse_object
from homebot.integrations.zigbee2mqtt.formats.bridge_device import BridgeDevice, read_bridge_device
from homebot.integrations.zigbee2mqtt.formats.expose import SPECIFIC_TYPES
from homebot.integrations.zigbee2mqtt.formats.parts import build_parts

_TYPES = ("light", "switch", "cover")
"""A lock is left out: it is not approved by its group."""

_MAX_BYTES = 65_536

_RECALL = "scene_recall"
"""The command for a scene, of which the bridge does not tell the values."""

_COLORS = {"color_xy": "color", "color_hs": "color"}
_ASKED = 4
"""The bit of the access of what can be asked for."""

_Exposes: TypeAlias = Mapping[str, Mapping[str, Mapping[str, object]]]
ExposesOfEndpoints: TypeAlias = Mapping[str, _Exposes]
"""See :attr:`GroupMember.exposes`, by the name of the endpoint; empty for the device itself."""


class GroupMember(NamedTuple):
    """A device in a group, or one of its endpoints.

    Attributes:
        topic: Where it is asked for its state, without ``/get``.
        exposes: Its exposes of the types that a group may have: by type, the features by name.
    """

    topic: str
    exposes: _Exposes

    @property
    def question(self) -> Mapping[str, str]:
        """A question for all values that it tells when asked."""
        question = {}
        for features in self.exposes.values():
            for name, feature in features.items():
                access = feature.get("access")
                if isinstance(access, int) and access & _ASKED:
                    question[_COLORS.get(name, name)] = ""
        return question


def exposes_of_groups(device: BridgeDevice) -> ExposesOfEndpoints:
    """Return the exposes of the endpoints of *device*; see :attr:`GroupMember.exposes`."""
    exposes: dict[str, dict[str, dict[str, Mapping[str, object]]]] = {}
    for expose in map(as_fields, device.exposes if isinstance(device.exposes, list) else ()):
        kind, endpoint, features = expose.get("type"), expose.get("endpoint", ""), expose.get("features")
        if kind in _TYPES and isinstance(endpoint, str) and isinstance(features, list):
            own = [
                feature for feature in map(as_fields, features) if str(feature.get("name")) in SPECIFIC_TYPES[str(kind)]
            ]
            named: dict[str, Mapping[str, object]] = {
                str(feature["name"]): {**feature, "property": feature.get("name"), "endpoint": None} for feature in own
            }
            of_endpoint = exposes.setdefault(endpoint, {})
            of_endpoint[str(kind)] = named
            if kind == "light" and "state" in named:  # in a group with plugs
                of_endpoint.setdefault("switch", {"state": named["state"]})
    return exposes


def build_group(
    base: str, entry: Mapping[str, object], members: Sequence[GroupMember]
) -> tuple[BridgeDevice, tuple[DescribedPart, ...]]:
    """Return the group of an *entry* as a device, and its parts: the features common to all *members*, and its scenes.

    Raises:
        WireError: Its name cannot be a topic of its own.
    """
    kinds = [kind for kind in _TYPES if members and all(kind in member.exposes for member in members)]
    exposes = [_common(kind, members) for kind in kinds[:1]]
    listed = {"endpoints": {"1": {"name": "1", "scenes": entry.get("scenes")}}, "power_source": "Battery"}
    device = read_bridge_device(base, {**entry, **listed, "definition": {"exposes": exposes}})
    parts = build_parts(device) if exposes else ()
    return device, tuple([part._replace(codec=_GroupCodec(part.codec, members)) for part in parts])


def _common(kind: str, members: Sequence[GroupMember]) -> dict[str, object]:
    """Return an expose with the features that all have, in the narrowest bounds."""
    known = [member.exposes[kind] for member in members]
    names = [name for name in known[0] if all(name in features for features in known)]
    return {"type": kind, "features": [_narrowest([features[name] for features in known]) for name in names]}


def _narrowest(features: Sequence[Mapping[str, object]]) -> dict[str, object]:
    narrowest = dict(features[0])
    for key, pick in (("value_min", max), ("value_max", min)):
        if numbers := [bound for feature in features if isinstance(bound := feature.get(key), int | float)]:
            narrowest[key] = pick(numbers)
    return narrowest


class _GroupCodec:
    """The codec of a group, which asks the members for the result of a command."""

    def __init__(self, own: Codec, members: Iterable[GroupMember]) -> None:
        assert isinstance(own, WritesSeveral), "the codec of a device"  # noqa: S101 - for the type checker
        self.topics, self.read, self.write, self.write_several = own.topics, own.read, own.write, own.write_several
        self._members = tuple(members)

    def questions(self, sent: Publications) -> Publications:
        """See :class:`homebot.conventions.description.AsksMembers`."""
        keys = {
            key: ""
            for publication in sent
            for key in parse_object(publication.payload, _MAX_BYTES)
            if key != "transition"
        }
        asked = ((member.topic, keys if keys and _RECALL not in keys else member.question) for member in self._members)
        return tuple(
            [Publication(f"{topic}/get", compact_json(question).encode()) for topic, question in asked if question]
        )
