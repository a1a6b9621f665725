"""Next steps for services that another gateway can use, while that is not configured. Pure.

Sources: Home Assistant core 2024.3, ``components/zeroconf/__init__.py``; HomeKit Accessory Protocol Specification R2,
6.4 and table 6-8 (status flags).
"""

from collections.abc import Callable, Collection, Mapping
from typing import Final, NamedTuple

from homebot.conventions.dns_sd import FoundService, name_of, printable
from homebot.devices.names import NEEDS_GATEWAY, NEXT_STEP

__all__ = ["hint_facts"]


class _Hint(NamedTuple):
    """The gateway of a service type, and the next step with a service of it; empty for none."""

    gateway: str
    next_step: Callable[[FoundService], str]


def hint_facts(service: FoundService, configured: Collection[str] | None) -> dict[str, str]:
    """Return the gateway that *service* needs and the next step, as facts; none if that gateway is *configured*.

    Args:
        configured: The plug-ins of the configured gateways; None if they are unknown, which gives no facts.
    """
    hint = _HINTS.get(service.service_type)
    if hint is None or configured is None or hint.gateway in configured:
        return {}
    step = hint.next_step(service)
    return {NEEDS_GATEWAY: hint.gateway, NEXT_STEP: printable(step)} if step else {}


def _home_assistant(service: FoundService) -> str:
    default = f"http://{service.host.rstrip('.')}:{service.port}"
    url = service.properties.get("internal_url") or service.properties.get("base_url") or default
    token = "a long-lived access token (in Home Assistant: your profile, Security)"  # noqa: S105 - none itself
    return f'if it is yours, add [gateways.homeassistant] with url = "{url[:200]}" and token_file, a file with {token}'


def _hue(service: FoundService) -> str:
    return f"add [gateways.hue], then: homebot pair '{name_of(service)}'"


def _homekit(service: FoundService) -> str:
    flags = service.properties.get("sf", "")
    is_free = flags.isdecimal() and len(flags) <= _FLAG_DIGITS and bool(int(flags) & 1)
    return f"add [gateways.homekit], then: homebot pair '{name_of(service)}' CODE" if is_free else ""


_FLAG_DIGITS: Final = 3
"""Decimal digits of the status flags, which are a byte."""

_HINTS: Final[Mapping[str, _Hint]] = {
    "_hap._tcp.local.": _Hint("homekit", _homekit),
    "_hap._udp.local.": _Hint("homekit", _homekit),
    "_home-assistant._tcp.local.": _Hint("homeassistant", _home_assistant),
    "_hue._tcp.local.": _Hint("hue", _hue),
}
