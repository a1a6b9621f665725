"""The services by which a gateway pairs homebot with devices, and the file with the secrets that this yields."""

import json
import os
from collections.abc import Awaitable, Callable, Iterable, Mapping
from itertools import islice
from pathlib import Path
from typing import Annotated, Final, Literal, Protocol, Self

from anyio import to_thread
from pydantic import ConfigDict, Field

from homebot.devices.names import PairingNames
from homebot.errors import LinkError, PeerError, RefusedError, UnableError, UsageError
from homebot.gateways.base import Gateway
from homebot.graph import Node
from homebot.messages.message import Message, ServiceAnswer, ServiceType
from homebot.support.file_access import check_secret_file, replace_file
from homebot.support.installation import Installation

MAX_UNPAIRED: Final = 100
_MAX_BYTES: Final = 4 * 1024 * 1024


class PairRequest(Message):
    """Request to pair homebot with a device.

    Attributes:
        device: The gateway's key of the device.
        code: The code on the device; empty if a button is pressed instead. It is a secret that is used once and never
            shown.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    device: str
    code: Annotated[str, Field(repr=False, max_length=255)] = ""


class UnpairRequest(Message):
    """Request to end the pairing with a device.

    Attributes:
        device: The gateway's key of the device.
    """

    device: str


class UnpairedDevice(Message):
    """A device that waits to be paired.

    Attributes:
        device: The gateway's key of it; empty for any device that has a code.
        takes_code: Whether it is paired by the code on it, and not by a button.
        within_s: Seconds that pairing may take, such as those for which the button is waited for.
        problem: Why it cannot be paired now; empty if it can.
    """

    device: str
    name: str
    takes_code: bool
    within_s: float
    problem: str = ""


class UnpairedRequest(Message):
    """Request for the devices that wait to be paired."""


class UnpairedResponse(Message):
    """The devices that wait to be paired, at most :data:`MAX_UNPAIRED`."""

    devices: tuple[UnpairedDevice, ...] = ()


class PairResponse(ServiceAnswer):
    """The result of pairing or unpairing.

    Attributes:
        problem: ``refused`` by the gateway or the device; ``unreachable`` if the device cannot be reached now;
            ``busy`` while another device is paired.
    """

    problem: Literal["", "refused", "unreachable", "busy"] = ""
    key: str = ""
    name: str = ""


Pair = ServiceType("homebot/srv/Pair", PairRequest, PairResponse)
Unpair = ServiceType("homebot/srv/Unpair", UnpairRequest, PairResponse)
ListUnpaired = ServiceType("homebot/srv/ListUnpaired", UnpairedRequest, UnpairedResponse)


class ActingGateway(Protocol):
    """A gateway, as far as requests to pair its devices need it; see :class:`homebot.gateways.base.Gateway`."""

    @property
    def acts(self) -> bool:
        """True if commands are sent."""

    @property
    def observes_because(self) -> str:
        """The reason why not."""


class PairingGateway(ActingGateway, Protocol):
    """A gateway that pairs devices."""

    async def pair(self, key: str, code: str) -> str:
        """Pair with the device *key*, and return its name.

        Raises:
            LinkError: It cannot be reached now.
            PeerError: It cannot be paired; the message gives the reason and the remedy, and never the code.
        """

    async def unpair(self, key: str) -> str:
        """End the pairing with the device *key*, and return its name; errors as those of :meth:`pair`."""

    def unpaired(self) -> Iterable[UnpairedDevice]:
        """Return the devices that it knows and could pair."""


class PairingRequests:
    """Requests to pair or unpair devices, carried out one at a time."""

    def __init__(self, gateway: ActingGateway) -> None:
        self._gateway = gateway
        self._is_busy = False

    async def answer(self, what: str, work: Callable[[], Awaitable[tuple[str, str]]]) -> PairResponse:
        """Return the answer to a request.

        Args:
            work: Carries it out, and returns key and name of the device; raises LinkError or PeerError.
        """
        if self._is_busy:
            return PairResponse(success=False, message="another device is being paired", problem="busy")
        self._is_busy = True
        try:
            if not self._gateway.acts:
                raise RefusedError(what, self._gateway.observes_because)
            key, name = await work()
        except LinkError as exc:
            return PairResponse(success=False, message=str(exc), problem="unreachable")
        except PeerError as exc:
            return PairResponse(success=False, message=str(exc), problem="refused")
        finally:
            self._is_busy = False
        return PairResponse(success=True, key=key, name=name)


class PairingServices:
    """Serves :class:`homebot.devices.names.PairingNames`."""

    def __init__(self, gateway: PairingGateway, node: Node) -> None:
        self._gateway = gateway
        self._requests = PairingRequests(gateway)
        names = PairingNames(node.name)
        node.create_service(Pair, names.pair, self._pair, concurrent=True)
        node.create_service(Unpair, names.unpair, self._unpair, concurrent=True)
        node.create_service(ListUnpaired, names.unpaired, self._list_unpaired)

    def _list_unpaired(self, _: UnpairedRequest) -> UnpairedResponse:
        return UnpairedResponse(devices=tuple(islice(self._gateway.unpaired(), MAX_UNPAIRED)))

    async def _pair(self, request: PairRequest) -> PairResponse:
        async def work() -> tuple[str, str]:
            return request.device, await self._gateway.pair(request.device, request.code)

        return await self._requests.answer("pairing", work)

    async def _unpair(self, request: UnpairRequest) -> PairResponse:
        async def work() -> tuple[str, str]:
            return request.device, await self._gateway.unpair(request.device)

        return await self._requests.answer("unpairing", work)


class PairingFile:
    """The secrets of paired devices, in a file that only its owner can read.

    Args:
        path: The file, which need not exist; None to keep nothing, as in simulations.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path

    @classmethod
    def of(cls, gateway: Gateway, path: Path | None) -> Self:
        """Return the file of a gateway: *path*, or ``NAME.pairings.json`` beside the index."""
        folder = (gateway.context.service(Installation) or Installation()).folder
        return cls(path or (None if folder is None else folder / f"{gateway.node.name}.pairings.json"))

    def load(self) -> dict[str, dict[str, object]]:
        """Return the secrets of each device, by a name of the gateway's choice. Blocking.

        Raises:
            UsageError: The file cannot be read, or others can write it; the message never holds a secret.
        """
        if self._path is None:
            return {}
        try:
            with self._path.open("rb") as file:
                check_secret_file(self._path, os.fstat(file.fileno()))
                content = json.loads(file.read(_MAX_BYTES))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, RecursionError) as exc:
            reason = exc.strerror if isinstance(exc, OSError) else "it is not JSON"
            raise UsageError(f"the pairings in {self._path} cannot be read: {reason}") from None
        if not isinstance(content, dict):
            raise UsageError(f"the pairings in {self._path} cannot be read: it is not a JSON object")
        return {key: saved for key, saved in content.items() if isinstance(saved, dict)}

    async def keep(self, pairings: Mapping[str, Mapping[str, object]]) -> None:
        """Replace the content of the file, by a worker thread.

        Raises:
            UnableError: It cannot be written.
        """
        try:
            await to_thread.run_sync(self.save, pairings)
        except UsageError as exc:
            raise UnableError(str(exc)) from exc

    def save(self, pairings: Mapping[str, Mapping[str, object]]) -> None:
        """Replace the content of the file, whole or not at all. Blocking.

        Raises:
            UsageError: It cannot be written.
        """
        if self._path is None:
            return
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            replace_file(self._path, json.dumps(pairings, indent=1).encode())
        except OSError as exc:
            raise UsageError(f"the pairings cannot be kept in {self._path}: {exc.strerror}") from exc
