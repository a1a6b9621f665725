"""Shelly's devices as Bluetooth proxies, by the script of aioshelly; the only file that imports that library.

The script sends the advertisements that the device hears as events on homebot's own link. The library's scanner reads
these, and it writes its script by :class:`_ScriptCalls`; the library's own connections are not used. Such a proxy only
listens.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final, TypeAlias, cast

from anyio import to_thread

from homebot.conventions.payload import as_fields, text_of
from homebot.devices.identity import in_pairs
from homebot.errors import RefusedError
from homebot.plugins import check_extra
from homebot.support.ble_proxies import PROXY_EXTRA, ProxyGate

if TYPE_CHECKING:
    from homebot.integrations.shelly.formats.status import Fields

CallMethod: TypeAlias = "Callable[[str, Fields | None, Callable[[Fields, bytes], Awaitable[None]]], Awaitable[None]]"
"""See :meth:`homebot.integrations.shelly.driver.RpcLink.call`."""

Attach: TypeAlias = Callable[[str, str, str, Callable[[ProxyGate], object]], AbstractContextManager[object]]
"""See :meth:`homebot.support.ble_proxies.BleProxies.attached`."""

LIBRARY: Final = "aioshelly"

_EVENT: Final = "ble.scan_result"
_FORM: Final = 2
"""The form of events that the script is told to send: several advertisements in each."""


class BluetoothRelay:
    """Hands over the advertisements that a device hears.

    Args:
        about: The answer of its ``/shelly``.
    """

    def __init__(self, about: Fields) -> None:
        self._source = in_pairs(text_of(about.get("mac"))).upper()
        self._name = text_of(about.get("name")) or text_of(about.get("id"))
        self._scanner: Any = None
        self._gate: ProxyGate | None = None

    async def start(self, call: CallMethod, *, installs: bool) -> None:
        """Start the script.

        Args:
            installs: Whether a script that is missing is written.

        Raises:
            UsageError: The library is not installed.
            RefusedError: The device has no such script, or refuses.
            LinkError: The connection was lost.
        """
        check_extra("a Bluetooth proxy", PROXY_EXTRA, LIBRARY)
        library = await to_thread.run_sync(import_module, "aioshelly.ble")
        calls = _ScriptCalls(call)
        name = library.BLE_SCRIPT_NAME
        if not installs and name not in {script["name"] for script in await calls.script_list()}:
            raise RefusedError(self._name, f"it has no script {name}; a table [[gateways.ble.proxies]] installs it")
        await library.async_start_scanner(calls, active=False, event_type=_EVENT, data_version=_FORM)

    @contextmanager
    def attached(self, attach: Attach) -> Iterator[None]:
        """Hand over the advertisements that :meth:`forward` gets inside the block, after :meth:`start`.

        Raises:
            RefusedError: It is not taken.
        """
        library = import_module("aioshelly.ble")

        def make_scanner(gate: ProxyGate) -> object:
            self._gate, self._scanner = gate, library.create_scanner(self._source, self._name)
            return self._scanner

        with attach(self._source, self._name, "", make_scanner):
            try:
                yield
            finally:
                self._gate = None

    def forward(self, frame: Fields) -> bool:
        """Hand over the advertisements of a notification; return whether it is of the script.

        Events of another form are counted as refused.
        """
        events = as_fields(frame.get("params")).get("events")
        if self._gate is None or not isinstance(events, list):
            return False
        heard = [event for event in map(as_fields, events) if event.get("event") == _EVENT]
        for event in heard:
            self._scanner.async_on_event({"event": _EVENT, "data": [_FORM, self._admitted(event.get("data"))]})
        return bool(heard)

    def _admitted(self, data: object) -> list[object]:
        gate, parser = cast("ProxyGate", self._gate), import_module("aioshelly.ble.parser")
        try:
            form, rows = cast("list[Any]", data)
            parsed = parser.parse_ble_scan_result_event([_FORM, rows]) if form == _FORM else ()
            if not parsed and rows:
                raise ValueError(form)
        except Exception:  # noqa: BLE001 - of the library, by data of a device
            gate.refused += 1
            return []
        return [row for row, one in zip(rows, parsed, strict=True) if _is_admitted(gate, *one)]


def _is_admitted(gate: ProxyGate, address: str, rssi: object, raw: bytes) -> bool:
    return gate.admits(address, rssi if isinstance(rssi, int) else 1000, len(raw))


class _ScriptCalls:
    """The calls on scripts that the library makes, on homebot's link."""

    def __init__(self, call: CallMethod) -> None:
        self._call_method = call

    async def script_list(self) -> list[dict[str, Any]]:
        """Return id and name of each script."""
        scripts = (await self._call("Script.List")).get("scripts")
        listed = [as_fields(script) for script in scripts] if isinstance(scripts, list) else []
        return [{"id": script.get("id"), "name": script.get("name")} for script in listed]

    async def script_create(self, name: str) -> None:
        """Add a script without code."""
        await self._call("Script.Create", {"name": name})

    async def script_getcode(self, script_id: int) -> dict[str, Any]:
        """Return the code of a script, as ``data``; the library knows its own error for one without code."""
        errors = import_module("aioshelly.exceptions")
        try:
            return dict(await self._call("Script.GetCode", {"id": script_id, "offset": 0}))
        except RefusedError as exc:
            raise errors.RpcCallError(-1, str(exc)) from exc

    async def script_putcode(self, script_id: int, code: str) -> None:
        """Replace the code of a script."""
        await self._call("Script.PutCode", {"id": script_id, "code": code})

    async def script_start(self, script_id: int) -> None:
        """Start a script."""
        await self._call("Script.Start", {"id": script_id})

    async def script_stop(self, script_id: int) -> None:
        """Stop a script."""
        await self._call("Script.Stop", {"id": script_id})

    async def _call(self, method: str, params: Fields | None = None) -> Fields:
        answers: list[Fields] = []

        async def record_answer(answer: Fields, _frame: bytes) -> None:
            answers.append(answer)

        await self._call_method(method, params, record_answer)
        return answers[0] if answers else {}
