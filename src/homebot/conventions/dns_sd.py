"""Services on the network by DNS-SD: their types and TXT records, and the facts of their devices. Pure.

Source: RFC 6763, sections 4.1.2, 6.1 to 6.5, 7 and 9; RFC 6335, section 5.1 for the characters of a service name.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from homebot.devices.identity import HOST, identifiers, in_pairs, may_be_unique
from homebot.support.addresses import parse_address

ENUMERATION = "_services._dns-sd._udp.local."
"""The name that every service type on the network is listed under (RFC 6763, section 9)."""

_TYPE = re.compile(r"(?:_[^.]{1,63}\._sub\.)?_[a-z0-9](?:[a-z0-9-]{0,13}[a-z0-9])?\._(?:tcp|udp)\.local\.")


def full_type(text: str) -> str:
    """Return a service type in full: of ``_shelly._tcp`` that is ``_shelly._tcp.local.``, with the dot."""
    name = text.strip().rstrip(".").lower()
    return f"{name}." if name.endswith(".local") else f"{name}.local."


def is_service_type(full: str) -> bool:
    """Return whether *full* is a service type in full, perhaps with a subtype."""
    return full == ENUMERATION or _TYPE.fullmatch(full) is not None


def base_type(full: str) -> str:
    """Return a type without its subtype: ``_directory._sub._wot._tcp.local.`` becomes ``_wot._tcp.local.``."""
    return full.rpartition("._sub.")[2]


def instance_label(name: str, full: str) -> str:
    """Return the name for people in the full name of a service of the type *full*: its first label."""
    base = base_type(full)
    return name[: -len(base) - 1] if name.lower().endswith(f".{base}") else name


MAX_KEYS = 64
"""Keys that are read. Devices have up to twenty."""

_PRINTABLE = range(0x20, 0x7F)


@dataclass(frozen=True, slots=True)
class TxtRecord:
    r"""The content of a TXT record.

    Attributes:
        properties: Values by key in lower case; of a key that occurs twice the first value. A value that is not UTF-8
            has its other bytes written as ``\xff``; a key without a value has an empty one.
        problem: The rule that the record breaks, as text; empty for none. Valid keys are read all the same.
    """

    properties: Mapping[str, str] = field(default_factory=dict)
    problem: str = ""


def read_txt(data: bytes) -> TxtRecord:
    """Return the content of a TXT record.

    Args:
        data: The record: strings of up to 255 bytes, each after its length; as RFC 6763 says, one is passed over if
            it begins with ``=``, or if its key is not printable ASCII.
    """
    properties: dict[str, str] = {}
    problem = ""
    position = 0
    while position < len(data):
        end = position + 1 + data[position]
        if end > len(data):
            problem = f"its TXT record ends within a string of {data[position]} bytes"
        key, _, value = data[position + 1 : end].partition(b"=")
        position = end
        name = key.decode("ascii", "replace").lower()
        if not key or any(byte not in _PRINTABLE for byte in key) or name in properties:
            continue
        if len(properties) == MAX_KEYS:
            problem = f"its TXT record has more than {MAX_KEYS} keys"
            break
        properties[name] = value.decode("utf-8", "backslashreplace")
    return TxtRecord(properties, problem)


_HARDWARE = ("mac", "macaddr", "macaddress", "mac_address", "deviceid", "ethmac", "bridgeid")
"""Keys of TXT records that say the hardware address: of ESPHome, WLED, Tasmota, AirPlay, Hue and others. A ``bssid`` is
that of the access point, which all devices there have."""

_SEPARATORS = re.compile(r"[|,;\s]+")
"""Between the addresses of a device that says several."""

_DECLARED = ("serial", "serialnumber", "serial_number", "serialnum", "sn", "uuid", "udn", "usn", "id")
"""Keys for the identifier that the device gives itself."""

_SHORTEST = 8
"""Characters of a declared id: a shorter one, such as ``1``, belongs to many devices."""

_NAMES = ("friendly_name", "friendlyname", "fn")
"""Keys that say the name that people gave, of ESPHome and of Google Cast."""

_NAME_OF = {"_amzn-wplay._tcp.local.": "n"}
"""Further ones by type: of the Fire TVs of Amazon, which are called ``amzn.dmgr:`` and an id."""

_ID = re.compile(r"[0-9A-Za-z]+[_-][0-9A-Fa-f]{12,}|[0-9A-Fa-f]{12,}")
_ADDRESS_BEHIND = re.compile(r"\[((?:[0-9A-Fa-f]{2}[:-]){5}[0-9A-Fa-f]{2})\]$")
"""The end of a name such as ``office [00:0e:c6:12:34:56]`` of a computer; Bosch's controller writes hyphens."""

_PADDED = re.compile(r"^([0-9A-Fa-f]{12})0000$")
"""The host of a node on matter.js, such as Matterbridge: its hardware address and four zeros."""

_MAX_ADDRESSES = 8

_FACTS = {
    "manufacturer": ("manufacturer", "vendor", "mf", "usb_mfg", "mfg", "brand"),
    "model": ("model", "md", "ty", "app", "board", "modelid", "product_name", "product", "usb_mdl", "am", "vib"),
    "sw_version": (
        *("sw_version", "fw_version", "fw_ver", "firmwareversion", "fwversion", "fv", "osvers"),
        *("version", "ver", "srcvers"),  # of devices with others as well, these are of a protocol
    ),
}
"""Facts by their names in the directory, and the keys of TXT records that say them."""


@dataclass(frozen=True, slots=True)
class FoundService:
    """A service that was found on the network (RFC 6763).

    Attributes:
        key: Its full name, ``Hall._shelly._tcp.local.``: the key of the device at the gateway.
        name: Its instance name, for people: ``Hall``.
        service_type: ``_shelly._tcp.local.``
        host: The name of its host: ``shellyplus1-a8032abe54dc.local.``
        port: Its port, 1 to 65535.
        addresses: The addresses of its host, best first: IPv4, then IPv6, link-local ones with their scope.
        properties: The keys and values of its TXT record, as text; keys are lower case.
    """

    key: str
    name: str
    service_type: str
    host: str
    port: int
    addresses: tuple[str, ...]
    properties: Mapping[str, str] = field(default_factory=dict)


def facts_of(service: FoundService) -> dict[str, str]:
    """Return the facts of a service, as metadata of its device: DNS-SD's facts, and TXT as ``txt_<key>``."""
    facts = {
        "dns_sd_type": service.service_type.removesuffix(".local."),
        "host": service.host.removesuffix("."),
        "port": str(service.port),
        "ip_address": next(iter(service.addresses), ""),
    }
    for fact, keys in _FACTS.items():
        facts[fact] = next((service.properties[key] for key in keys if service.properties.get(key)), "")
    facts |= {f"txt_{key}": value for key, value in service.properties.items()}
    return {name: printable(value) for name, value in facts.items() if value}


def identifiers_of(service: FoundService, declared: Iterable[str] | None = None) -> tuple[str, ...]:
    """Return the identifiers of a service's device beyond this gateway; see :mod:`homebot.devices.identity`.

    A host name and an instance name count where they contain a hardware address: without one, they are names that
    people give. For the host as such, see :func:`host_identifiers`.

    Args:
        declared: What it declares, if its ecosystem has a rule of its own.
    """
    said = service.properties
    label = _PADDED.sub(r"\1", service.host.removesuffix(".").removesuffix(".local"))
    named = [label] if _has_address(label, "mac:", "eui64:") else []
    # Not of 64 bits: the node of a fabric is called <fabric>-<node>, and neither is an address.
    named += [name for name in (service.name, service.name.partition("@")[0]) if _has_address(name, "mac:")]
    named += [match[1] for match in _ADDRESS_BEHIND.finditer(service.name)]
    if declared is None:
        known = [said.get(key, "") for key in _DECLARED]
        declared = [identifier for identifier in known if len(identifier) >= _SHORTEST and may_be_unique(identifier)]
    hardware = [
        in_pairs(address) for key in _HARDWARE for address in _SEPARATORS.split(said.get(key, ""))[:_MAX_ADDRESSES]
    ]
    return identifiers([*hardware, *named, *declared])


def host_identifiers(service: FoundService) -> tuple[str, ...]:
    """Return the identifier that all services of one host have; none for a group of speakers that one announces."""
    is_group = service.properties.get("md") == "Google Cast Group"
    return () if is_group else (f"{HOST}{printable(service.host).removesuffix('.').casefold()}",)


def name_of(service: FoundService, key: str = "") -> str:
    """Return the name of a service for people: its instance name without the address that some put into it.

    A name in the TXT record comes first, also that of the *key* of its ecosystem: there the instance name is made of an
    id (Google Cast, Amazon).
    """
    for property_name in (*_NAMES, key, _NAME_OF.get(service.service_type, "")):
        if name := printable(service.properties.get(property_name, "")).strip():
            return name
    before, _, after = service.name.partition("@")
    if after.strip() and (_has_address(before, "mac:") or _ID.fullmatch(before)):
        return after.strip()
    return _ADDRESS_BEHIND.sub("", service.name).rstrip() or service.name


def usable_addresses(found: Iterable[str], *, with_loopback: bool) -> tuple[str, ...]:
    """Return those of the addresses *found* that can be connected to, best first: IPv4, IPv6, then link-local ones.

    Args:
        found: Addresses, as text; link-local ones of IPv6 with their scope, without which they lead nowhere.
        with_loopback: Whether a loopback address is this computer's own service. One that was announced on a network
            would let any neighbour have us connect to services for this computer alone.
    """
    ranked: dict[str, int] = {}
    for text in found:
        address = parse_address(text)
        if (
            address is None
            or address.is_multicast
            or address.is_unspecified
            or (address.is_loopback and not with_loopback)
        ):
            continue
        if address.version == 6 and address.is_link_local and "%" not in text:
            continue
        ranked[text] = 2 * address.is_link_local + (address.version == 6)
    return tuple(sorted(ranked, key=lambda one: (ranked[one], one)))


def printable(text: str) -> str:
    """Return *text* with everything replaced that does not show, such as control characters."""
    return (
        text
        if text.isprintable()
        else "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in text)
    )


def _has_address(text: str, *kinds: str) -> bool:
    return any(identifier.startswith(kinds) for identifier in identifiers([text]))
