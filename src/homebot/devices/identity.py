"""Identity of a device: the set of its identifiers, in normal form. Pure.

An identifier is ``mac:aabbccddeeff``, ``eui64:00158d0001abcdef`` or ``id:<text as declared>``. A hardware address at
the end of another identifier, as in ``zigbee2mqtt_0x00158d0001abcdef``, counts too. One in its middle does not: a
bridge names its devices ``<bridge>_<address of the bridge>_<device>``. A service of a computer names its host:
``id:host nas.local``, see :data:`HOST`.
"""

import re
from collections.abc import Iterable

HOST = "id:host "
"""The beginning of the identifier of all services of one host: its name in the local network, case-folded.

Host names are unique in one local network, so it is valid among the announcements of one gateway."""

_ALIASING_BRIDGE = "zigbee2mqtt_bridge_"
_BEHIND_IT = "id:zigbee2mqtt_0x"
"""The beginnings of the identifiers of the bridge and of a device behind it; announcements may lack either."""

_PAIRS = re.compile(
    r"(?:.*[^0-9a-f:-])?([0-9a-f]{2}(?:([:-])[0-9a-f]{2})(?:\2[0-9a-f]{2}){4}(?:(?:\2[0-9a-f]{2}){2})?)"
)
_DIGITS = re.compile(r"(?:.*[^0-9a-f])?(?:0x)?([0-9a-f]{16}|[0-9a-f]{12})", re.DOTALL)

_PLAIN = re.compile("[0-9A-Fa-f]{12}(?:[0-9A-Fa-f]{4})?")

_NO_ADDRESS = re.compile(
    r"(?:.*[^0-9a-f])?[0-9a-f]{8}-[0-9a-f]{4}-[3-578][0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}", re.DOTALL
)
"""A UUID (RFC 9562) that is random or derived from a name, without an address; version 1 ends with one."""

_SHORTEST = 6
"""Characters, without leading zeros, from which a serial number counts as unique."""

_FILLERS = "0123456789" * 4, "0123456789abcdef", "9876543210"
"""Beginnings, ends and middles of these stand for a serial number, as do groups of them: ``12345678-1234-1234``."""

_NOBODY = frozenset({"000000000000", "ffffffffffff", "0000000000000000", "ffffffffffffffff"})
_MAC_DIGITS = 12


def identifiers(declared: Iterable[str]) -> tuple[str, ...]:
    """Return the identifiers in *declared* in normal form, without repetition, hardware addresses first.

    Args:
        declared: The spelling of the device or its bridge; empty ones are left out.
    """
    hardware: dict[str, None] = {}
    others: dict[str, None] = {}
    for text in declared:
        spelled = text.strip()
        folded = spelled.casefold()
        address = _address(folded)
        if address:
            kind = "mac" if len(address) == _MAC_DIGITS else "eui64"
            hardware[f"{kind}:{address}"] = None
        if spelled and folded.replace(":", "").replace("-", "").removeprefix("0x") != address:
            others[f"id:{spelled}"] = None
    return (*hardware, *others)


def aliasing_bridge(bridge: str, known_by: Iterable[str]) -> str:
    """Return the bridge that takes commands to a device on further topics; empty for none.

    These are the address of the device, its groups, and each endpoint. Without the address of the bridge, it is the
    beginning of such identifiers.

    Args:
        bridge: The identifier of the device behind which it is, as declared; empty for none.
        known_by: Its own identifiers.
    """
    if bridge.startswith(f"{_ALIASING_BRIDGE}0x"):
        return bridge
    is_behind = bridge.startswith(_ALIASING_BRIDGE) or (not bridge and _BEHIND_IT in " ".join(known_by))
    return _ALIASING_BRIDGE if is_behind else ""


def in_pairs(address: str) -> str:
    """Return the digits of a hardware address with colons, so that decimal digits are not mistaken for a serial number.

    Args:
        address: The hardware address that the device states; anything but 12 or 16 digits is returned unchanged.
    """
    is_plain = _PLAIN.fullmatch(address) is not None
    return ":".join(address[at : at + 2] for at in range(0, len(address), 2)) if is_plain else address


def may_be_unique(serial: str, model: str = "") -> bool:
    """Return whether *serial* may be of one device alone: many are ``00000001``, ``1234567890`` or the *model*."""
    groups = re.findall("[0-9a-z]+", serial.casefold())
    plain = "".join(groups)
    is_filler = len(set(plain)) <= 2 or all(any(group in row for row in _FILLERS) for group in groups)
    return len(serial.lstrip("0")) >= _SHORTEST and any(map(str.isdigit, plain)) and serial != model and not is_filler


def _address(text: str) -> str:
    """Return the hardware address with which *text* ends; empty if there is none.

    Twelve decimal digits without separators are more likely a serial number or a time.
    """
    if "-" in text and _NO_ADDRESS.fullmatch(text):
        return ""
    if (":" in text or "-" in text) and (match := _PAIRS.fullmatch(text)):
        digits = match.group(1).replace(":", "").replace("-", "")
    elif match := _DIGITS.fullmatch(text):
        digits = match.group(1)
        if digits.isdecimal() and len(digits) == _MAC_DIGITS:
            return ""
    else:
        return ""
    return "" if digits in _NOBODY else digits
