"""Devices without a Thing Description, as things: the resources in their links. Pure.

Those of IPSO are known by the numbers in their path. Another resource that can be observed, or that its interface calls
a sensor, is there to be read as a text.

Source: OMA LwM2M registry, objects 3200 to 3347; RFC 9176 and the CoRE interfaces draft (``core.s``, ``core.a``) for
``if``.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from types import MappingProxyType
from urllib.parse import unquote

from homebot.conventions.coap.link_format import WebLink
from homebot.conventions.payload import clean_text
from homebot.integrations.things.formats.content_formats import coap_formats, content_type_of
from homebot.integrations.things.formats.thing import Affordance, DataSchema, DataType, Form, Thing

MAX_RESOURCES = 64
"""Resources of one device that are used; the first in the order of their paths."""


@dataclass(frozen=True, slots=True)
class _Known:
    """A known kind of resource.

    Attributes:
        enum: The two spellings of no and yes, for a boolean that is spelt as text.
    """

    name: str
    type: DataType
    unit: str = ""
    bounds: tuple[float, float] | None = None
    settable: bool = False
    enum: tuple[str, ...] = ()


_ONE_OR_ZERO = ("0", "1")
_IPSO: Mapping[tuple[int, int], _Known] = {
    (3200, 5500): _Known("state", "string", enum=_ONE_OR_ZERO),
    (3201, 5550): _Known("on", "string", settable=True, enum=_ONE_OR_ZERO),
    (3300, 5700): _Known("measurement", "number"),
    (3301, 5700): _Known("illuminance", "number", "lux"),
    (3302, 5500): _Known("motion", "string", enum=_ONE_OR_ZERO),
    (3303, 5700): _Known("temperature", "number", "celsius"),
    (3304, 5700): _Known("humidity", "number", "%"),
    (3305, 5800): _Known("power", "number", "W"),
    (3306, 5850): _Known("on", "string", settable=True, enum=_ONE_OR_ZERO),
    (3308, 5900): _Known("set_point", "number", settable=True),
    (3311, 5850): _Known("on", "string", settable=True, enum=_ONE_OR_ZERO),
    (3311, 5851): _Known("brightness", "integer", "%", (0, 100), settable=True),
    (3312, 5850): _Known("on", "string", settable=True, enum=_ONE_OR_ZERO),
    (3315, 5700): _Known("barometer", "number"),
    (3316, 5700): _Known("voltage", "number", "V"),
    (3317, 5700): _Known("current", "number", "A"),
    (3318, 5700): _Known("frequency", "number", "Hz"),
    (3320, 5700): _Known("percentage", "number", "%"),
    (3323, 5700): _Known("gauge", "number"),
    (3325, 5700): _Known("concentration", "number"),
    (3328, 5700): _Known("power", "number", "W"),
    (3330, 5700): _Known("distance", "number"),
    (3331, 5805): _Known("energy", "number", "Wh"),
    (3337, 5536): _Known("positioner", "number", "%", (0, 100), settable=True),
    (3342, 5500): _Known("on", "string", enum=_ONE_OR_ZERO),
    (3343, 5548): _Known("brightness", "number", "%", (0, 100), settable=True),
    (3347, 5500): _Known("state", "string", enum=_ONE_OR_ZERO),
}
"""By object and resource; of a quantity with its unit in another resource, the number alone is known."""

_IPSO_INSTANCE = re.compile(r"(?:.*/)?(3[23]\d\d)/\d{1,5}")
_IPSO_PATH = re.compile(r"(?:.*/)?(3[23]\d\d)/\d{1,5}/(5\d{3})/?")
_LIGHT = "3311"
_OF_INSTANCE: Mapping[str, str] = MappingProxyType({"on": "on_off", "brightness": "level"})
"""The capabilities that belong to one instance of an IPSO object, by the names of properties."""

_READ_ONLY = frozenset({"core.s", "core.rp", "core.lb", "sensor"})
_ACTUATORS = frozenset({"core.a", "core.p", "actuator"})
_NEVER = ("/.well-known/", "/rd", "/bs")


def thing_of_links(links: Iterable[WebLink], resolve: Mapping[str, str], name: str) -> Thing:
    """Return the thing with the resources of *links*, one device's; *resolve* has the absolute addresses by target."""
    given = tuple(links)
    implied = {link: href for source in given for link, href in _implied(source, given, resolve[source.target])}
    resolve = {**resolve, **{link.target: href for link, href in implied.items()}}
    listed = sorted((*given, *implied), key=attrgetter("target"))
    lamps = [instance for link in listed if (instance := _instance(link, _LIGHT))]
    affordances = [made for link in listed if (made := _affordance(link, resolve[link.target], lamps)) is not None]
    return Thing(
        id="",
        title=name,
        types=("Light",) if lamps else (),
        description="",
        affordances=tuple(affordances[:MAX_RESOURCES]),
    )


def _implied(link: WebLink, listed: Iterable[WebLink], href: str) -> Iterator[tuple[WebLink, str]]:
    """Yield the resource that an instance of an IPSO object must have, where the device lists the instance alone.

    LwM2M devices do: ``</3303/0>``, section 6.4.1 of the LwM2M Core specification.
    """
    target = link.target.rstrip("/")
    match = _IPSO_INSTANCE.fullmatch(target)
    if match is None or not href or any(link.target.startswith(f"{target}/") for link in listed):
        return
    number = next((resource for known, resource in _IPSO if known == int(match[1])), None)
    if number is not None:
        yield WebLink(f"{target}/{number}"), f"{href.rstrip('/')}/{number}"


def _instance(link: WebLink, number: str = "") -> str:
    """Return the path of the instance of an IPSO object that has the resource; of the object *number*, where given."""
    match = _IPSO_PATH.fullmatch(link.target)
    is_it = match is not None and number in {"", match[1]}
    return link.target.strip("/").rpartition("/")[0] if is_it else ""


def _place(link: WebLink, known: _Known, lamps: Sequence[str]) -> Mapping[str, str]:
    """Return the part of a resource beside *lamps*: each lamp is one, and no relay is the switch of a lamp."""
    instance, capability = _instance(link), _OF_INSTANCE.get(known.name, "")
    if not instance or not capability or not lamps:
        return {}
    if instance == lamps[0]:
        return {"capability": capability, "serviceType": "light", "part": "", "advertised": "Light"}
    kind = "light" if instance in lamps else "switch"
    name = clean_text(link.get("title"), 60)
    return {"capability": capability, "serviceType": kind, "part": instance, "name": name, "guessed": "true"}


def _affordance(link: WebLink, href: str, lamps: Sequence[str]) -> Affordance | None:
    known = _kind(link)
    if known is None or link.target.startswith(_NEVER) or not href:
        return None
    named = [content_type_of(int(word)) for word in link.words("ct") if word.isdecimal() and len(word) <= 5]
    content_type: str | None = "text/plain"
    if named:
        content_type = next((known_type for known_type in named if coap_formats(known_type) is not None), None)
    if content_type is None:
        return None
    interfaces = frozenset(link.words("if"))
    is_settable = known.settable and (interfaces.isdisjoint(_READ_ONLY) or not interfaces.isdisjoint(_ACTUATORS))
    low, high = known.bounds or (None, None)
    return Affordance(
        name=known.name,
        kind="property",
        title=clean_text(link.get("title"), 60),
        types=(),
        schema=DataSchema(known.type, known.unit, low, high, known.enum),
        read_only=not is_settable,
        write_only=False,
        forms=_forms(link, href, content_type),
        extension=_place(link, known, lamps),
    )


def _kind(link: WebLink) -> _Known | None:
    """Return the kind of a resource; None for one that is no value."""
    match = _IPSO_PATH.fullmatch(link.target)
    if match is not None and (known := _IPSO.get((int(match[1]), int(match[2])))) is not None:
        return known
    if not link.has("obs") and _READ_ONLY.isdisjoint(link.words("if")):
        return None
    last = unquote(link.target.rstrip("/").rpartition("/")[2])
    return _Known(clean_text(link.get("title") or last, 60) or "value", "string")


def _forms(link: WebLink, href: str, content_type: str) -> tuple[Form, ...]:
    scheme = href.partition(":")[0].lower()
    observed = Form(("observeproperty",), scheme, href, subprotocol="cov:observe", content_type=content_type)
    return (
        *((observed,) if link.has("obs") else ()),
        Form(("readproperty",), scheme, href, content_type=content_type),
        Form(("writeproperty",), scheme, href, method="PUT", content_type=content_type),
    )
