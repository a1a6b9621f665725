"""Port of ecosystems: what integrations know of devices on the network, and of the codes on them. Pure."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from homebot.conventions.dns_sd import FoundService, printable
from homebot.devices.names import NEEDS_GATEWAY, NEXT_STEP
from homebot.errors import WireError
from homebot.plugins import load_plugin, plugin_names

_GROUP = "homebot.ecosystems"


@dataclass(frozen=True, slots=True)
class SetupCode:
    """The facts in a setup code, without its secret.

    Attributes:
        kind: As in :class:`homebot.devices.tags.ScanCodeResponse`.
        text: The device in words.
        facts: The facts, by their names in the directory.
        fits: Returns whether a device with these metadata, by keys in lower case, is the one with the code.
    """

    kind: str
    text: str
    facts: Mapping[str, str]
    fits: Callable[[Mapping[str, str]], bool] = field(compare=False)


class Ecosystem:
    """The devices of one ecosystem, as its integration knows them; the plug-in group is ``homebot.ecosystems``.

    Attributes:
        service_types: The types of their DNS-SD services, in full: ``_hap._tcp.local.``.
        name_key: The key of TXT records that says the name which people gave; empty for none.
        gateway: The plug-in of the gateway that works with these services; empty for none.
        server: The scheme and the usual port of the server to which the gateway connects; None for none.
        is_shared: Whether devices of other ecosystems belong to it too, whose own gateways come first.
        code_prefix: The beginning of the text of their setup codes, in capitals; empty for none.
    """

    service_types: ClassVar[frozenset[str]] = frozenset()
    name_key: ClassVar[str] = ""
    gateway: ClassVar[str] = ""
    server: ClassVar[tuple[str, int] | None] = None
    is_shared: ClassVar[bool] = False
    code_prefix: ClassVar[str] = ""

    @classmethod
    def declared(cls, service: FoundService) -> Iterable[str] | None:
        """Return the identifiers that *service* declares; None for those that any service may declare."""
        del service
        return None

    @classmethod
    def is_own(cls, service: FoundService) -> bool:
        """Return whether *service* is homebot itself, which is no device of the house."""
        del service
        return False

    @classmethod
    def next_step(cls, service: FoundService) -> str:
        """Return the next step with *service*, which no configured gateway uses; empty for none."""
        del service
        return ""

    @classmethod
    def read_code(cls, text: str) -> SetupCode:
        """Return the facts in *text*, which begins like a setup code.

        Raises:
            WireError: It is none; the message does not show it.
        """
        raise WireError(f"a device of {cls.__name__} has no setup code", text.encode())


def ecosystems() -> tuple[type[Ecosystem], ...]:
    """Return the installed ecosystems."""
    return tuple(load_plugin(_GROUP, name) for name in plugin_names(_GROUP))


def hint_facts(known: type[Ecosystem], service: FoundService, configured: Collection[str] | None) -> dict[str, str]:
    """Return the gateway that *service* needs and the next step, as facts; none if that gateway is *configured*.

    Args:
        configured: The plug-ins of the configured gateways; None if they are unknown, which gives no facts.
    """
    step = "" if configured is None or known.gateway in configured else known.next_step(service)
    return {NEEDS_GATEWAY: known.gateway, NEXT_STEP: printable(step)} if step else {}


def read_setup_code(text: str) -> SetupCode | None:
    """Return the facts in *text*; None if no installed ecosystem has such codes.

    Raises:
        WireError: It is invalid; the message does not show it.
    """
    kinds = (kind for kind in ecosystems() if kind.code_prefix and text.upper().startswith(kind.code_prefix))
    return next((kind.read_code(text) for kind in kinds), None)
