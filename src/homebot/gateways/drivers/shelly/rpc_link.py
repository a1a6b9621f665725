"""Calls and notifications over one WebSocket of a Shelly.

Frames are handled in the order of arrival: an answer reaches its caller before the next notification is handled, so
that an old status never replaces a newer one. At most three calls run at once, because devices have little memory;
signed calls run one at a time, because each challenge invalidates the one before.

Source: Shelly Gen2+ API, General: RPC Protocol (frames, common errors), RPC Channels (WebSocket), Notifications.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import anyio
import anyio.lowlevel

from homebot.conventions.payload import as_fields, clean_text, compact_json, parse_object
from homebot.conventions.shelly.gen2 import MAX_ANSWER_BYTES
from homebot.conventions.shelly.gen2_component import Fields
from homebot.conventions.shelly.gen2_rpc import CLIENT
from homebot.conventions.shelly.rpc_login import RpcLogin
from homebot.errors import HomebotError, LinkError, RefusedError, WireError
from homebot.gateways.http_websocket import WebSocket

__all__ = ["RpcLink", "TakeFrame"]

TakeFrame: TypeAlias = Callable[[Fields, bytes], Awaitable[None]]
"""Takes a frame: parsed, and as received."""

TIME_LIMIT: Final = 15.0
"""Seconds for an answer; a Bluetooth operation of a gateway takes several."""

_UNAUTHORIZED = 401
_LATER = frozenset({-104, -108, -114, 503})
"""Deadline exceeded, resource exhausted, unavailable."""


@dataclass(slots=True)
class _PendingCall:
    on_answer: TakeFrame | None
    answered: anyio.Event = field(default_factory=anyio.Event)
    frame: Fields | None = None


class RpcLink:
    """Sends calls and receives answers and notifications over one WebSocket.

    Args:
        socket: The WebSocket.
        name: What the device is called in errors.
        login: Signs calls; None where there is no password.
        on_notification: Takes notifications.
        on_invalid: Called with each invalid frame and the reason.

    Attributes:
        end: The error with which the link was lost; None while it is connected.
    """

    def __init__(
        self,
        socket: WebSocket,
        name: str,
        login: RpcLogin | None,
        on_notification: TakeFrame,
        on_invalid: Callable[[bytes, str], None],
    ) -> None:
        self._socket = socket
        self._name = name
        self._login = login
        self._on_notification = on_notification
        self._on_invalid = on_invalid
        self._pending: dict[int, _PendingCall] = {}
        self._last_id = 0
        self._turns = anyio.Semaphore(3 if login is None else 1)
        self._is_lost = False
        self.end: HomebotError | None = None

    async def receive(self) -> None:
        """Handle frames until the link is lost.

        Raises:
            LinkError: It is lost.
            WireError: Too many frames in a row broke the rules, or one was too long.
        """
        try:
            await self._socket.receive_all(self._take, self._on_invalid)
        except HomebotError as exc:
            self.end = exc
            raise
        finally:
            self._is_lost = True
            for call in self._pending.values():
                call.answered.set()

    async def call(self, method: str, params: Fields | None = None, on_answer: TakeFrame | None = None) -> Fields:
        """Call a method, and return its result.

        Args:
            method: The method.
            params: Its parameters; None for none.
            on_answer: Called with the result and its frame before any later frame is handled.

        Raises:
            LinkError: The link is lost, there was no answer in time, or the device says that it may work later.
            RefusedError: The device refuses, or wants a password, or another one.
            WireError: The answer breaks the rules.
        """
        async with self._turns:
            frame = await self._exchange(method, params, on_answer)
            error = frame.get("error")
            if self._login is not None and as_fields(error).get("code") == _UNAUTHORIZED:
                self._login.take_challenge(str(as_fields(error).get("message")))
                frame = await self._exchange(method, params, on_answer)
        if "error" in frame:
            raise self._error(method, as_fields(frame["error"]))
        return as_fields(frame.get("result"))

    async def _exchange(self, method: str, params: Fields | None, on_answer: TakeFrame | None) -> Fields:
        if self._is_lost:
            await anyio.lowlevel.checkpoint()  # where the caller is cancelled together with the link, it was not lost
            raise LinkError(f"the connection to {self._name} was lost")
        self._last_id += 1
        frame: dict[str, object] = {"id": self._last_id, "src": CLIENT, "method": method}
        if params is not None:
            frame["params"] = params
        if self._login is not None and self._login.is_challenged:
            frame["auth"] = self._login.sign()
        call = self._pending[self._last_id] = _PendingCall(on_answer)
        try:
            with anyio.fail_after(TIME_LIMIT):
                await self._socket.send(compact_json(frame))
                await call.answered.wait()
        except TimeoutError:
            raise LinkError(f"{self._name} did not answer {method} within {TIME_LIMIT:g} s") from None
        finally:
            self._pending.pop(int(str(frame["id"])), None)
        if call.frame is None:
            await anyio.lowlevel.checkpoint()  # where the caller is cancelled together with the link, it was not lost
            raise LinkError(f"the connection to {self._name} was lost")
        return call.frame

    async def _take(self, payload: bytes) -> None:
        frame = parse_object(payload, MAX_ANSWER_BYTES)
        if "method" in frame:
            if not isinstance(frame["method"], str):
                raise WireError("the method of a frame is not a text")
            await self._on_notification(frame, payload)
            return
        number = frame.get("id")
        call = self._pending.get(number) if isinstance(number, int) and not isinstance(number, bool) else None
        if call is None or call.frame is not None:
            raise WireError("an answer belongs to no call")
        call.frame = frame
        try:
            if call.on_answer is not None and isinstance(frame.get("result"), dict):
                await call.on_answer(as_fields(frame["result"]), payload)
        finally:
            call.answered.set()

    def _error(self, method: str, error: Fields) -> RefusedError | LinkError:
        code, message = error.get("code"), error.get("message")
        what = f"{method} at {self._name}"
        if code == _UNAUTHORIZED:
            return RefusedError(what, wants_password(has_one=self._login is not None), _UNAUTHORIZED)
        reason = clean_text(message, 120) if isinstance(message, str) else "the device answered with an error"
        if code in _LATER:
            return LinkError(f"{what}: {reason}")
        return RefusedError(what, reason, code if isinstance(code, int) else None)


def wants_password(*, has_one: bool) -> str:
    """Return what to do when a device asks for a password, as text."""
    keys = "password_file or password_env in [gateways.mdns.drivers.shelly]"
    return f"it refuses the password given by {keys}" if has_one else f"it wants a password; give {keys}"
