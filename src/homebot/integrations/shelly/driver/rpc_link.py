"""Calls and notifications over one WebSocket of a Shelly.

Frames are handled in the order of arrival: an answer reaches its caller before the next notification is handled, so
that an old status never replaces a newer one. At most three calls run at once, because devices have little memory;
signed calls run one at a time, because each challenge invalidates the one before.

Source: Shelly Gen2+ API, General: RPC Protocol (frames, common errors), RPC Channels (WebSocket), Notifications.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Final, TypeAlias

import anyio

from homebot.conventions.payload import as_fields, clean_text, compact_json, parse_object
from homebot.errors import HomebotError, LinkError, RefusedError, WireError
from homebot.gateways.pending_calls import PendingCalls
from homebot.integrations.shelly.formats.gen2 import MAX_ANSWER_BYTES
from homebot.integrations.shelly.formats.gen2_rpc import CLIENT, RpcLogin
from homebot.integrations.shelly.formats.status import Fields

if TYPE_CHECKING:
    from homebot.gateways.http_streams import WebSocket

FrameHandler: TypeAlias = Callable[[Fields, bytes], Awaitable[None]]
"""Receives a frame: parsed, and raw."""

TIME_LIMIT: Final = 15.0
"""Seconds for an answer; a Bluetooth operation of a gateway takes several."""

_UNAUTHORIZED = 401
_LATER = frozenset({-104, -108, -114, 503})
"""Deadline exceeded, resource exhausted, unavailable."""


class RpcLink:
    """Sends calls and receives answers and notifications over one WebSocket.

    Args:
        login: Signs calls; None without a password.
        on_invalid: Called with each invalid frame and the reason.

    Attributes:
        end: The error with which the link was lost; None while it is connected.
    """

    def __init__(
        self,
        socket: WebSocket,
        name: str,
        login: RpcLogin | None,
        on_notification: FrameHandler,
        on_invalid: Callable[[bytes, str], None],
    ) -> None:
        self._socket = socket
        self._name = name
        self._calls = PendingCalls[tuple[Fields, bytes]](name)
        self._login = login
        self._on_notification = on_notification
        self._on_invalid = on_invalid
        self._turns = anyio.Semaphore(3 if login is None else 1)
        self.end: HomebotError | None = None

    async def receive(self) -> None:
        """Handle frames until the link is lost."""
        try:
            await self._socket.receive_all(self._handle_frame, self._on_invalid)
        except HomebotError as exc:
            self.end = exc
            raise
        finally:
            self._calls.end()

    async def call(self, method: str, params: Fields | None = None, on_answer: FrameHandler | None = None) -> Fields:
        """Call a method, and return its result.

        Args:
            on_answer: Called with the result and its frame before any later frame is handled.

        Raises:
            LinkError: The link is lost, there was no answer in time, or the device says that it may work later.
            RefusedError: The device refuses, or requires a password, or another one.
            WireError: The answer breaks the rules.
        """
        async with self._turns:
            frame = await self._exchange(method, params, on_answer)
            error = frame.get("error")
            if self._login is not None and as_fields(error).get("code") == _UNAUTHORIZED:
                self._login.accept_challenge(str(as_fields(error).get("message")))
                frame = await self._exchange(method, params, on_answer)
        if "error" in frame:
            raise self._error(method, as_fields(frame["error"]))
        return as_fields(frame.get("result"))

    async def _exchange(self, method: str, params: Fields | None, on_answer: FrameHandler | None) -> Fields:
        async def send(call_id: str) -> None:
            frame: dict[str, object] = {"id": int(call_id), "src": CLIENT, "method": method}
            if params is not None:
                frame["params"] = params
            if self._login is not None and self._login.is_challenged:
                frame["auth"] = self._login.sign()
            await self._socket.send(compact_json(frame))

        async def handle(answer: tuple[Fields, bytes]) -> None:
            frame, payload = answer
            if on_answer is not None and isinstance(frame.get("result"), dict):
                await on_answer(as_fields(frame["result"]), payload)

        frame, _ = await self._calls.call(method, send, TIME_LIMIT, handle)
        return frame

    async def _handle_frame(self, payload: bytes) -> None:
        frame = parse_object(payload, MAX_ANSWER_BYTES)
        if "method" in frame:
            if not isinstance(frame["method"], str):
                raise WireError("the method of a frame is not a text")
            await self._on_notification(frame, payload)
            return
        number = frame.get("id")
        if not isinstance(number, int) or not await self._calls.resolve(str(number), (frame, payload)):
            raise WireError("an answer belongs to no call")

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
    """Return the remedy for a device that requires a password, in words."""
    keys = "password_file or password_env in [gateways.mdns.drivers.shelly]"
    return f"it refuses the password given by {keys}" if has_one else f"it wants a password; give {keys}"
