"""A Shelly of the second generation on a channel of its own, such as a WebSocket. Pure.

The frames of all channels are alike, so parts read and write the same frames as over MQTT. Topics are only names of the
kinds of frames, without a broker.

Calls over a WebSocket are signed: a Digest in each frame, for one made-up method and address. From firmware 2.0.0 on
each call counts ``nc`` up; older ones take every count.

Source: Shelly Gen2+ API, General: RPC Protocol, RPC Channels (WebSocket), Notifications, Authentication; RFC 7616,
section 3.4.1.
"""

import hashlib
import secrets
from collections.abc import Collection, Iterator, Mapping
from typing import TypeAlias

from pydantic import SecretStr

from homebot.conventions.description import DescribedPart, DeviceAnnounced, WritesSeveral
from homebot.conventions.payload import Readings, as_fields, compact_json, parse_object
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.shelly.formats.gen2_device import AnswerKind, Gen2Device, is_config_change, sleeps
from homebot.integrations.shelly.formats.status import Fields
from homebot.support.numbers import to_number

CLIENT = "homebot"
"""The client id of calls to a device."""

PartKey: TypeAlias = tuple[str, str]
"""The key of a device, and the id of a part."""

RpcCall: TypeAlias = tuple[str, Fields]
"""Method and parameters of a call, such as ``Switch.Set``."""

_DAILY = 24 * 3600.0
_MAX_SILENCE_S = 7 * _DAILY
_MISSED = 2.5


class Gen2RpcDevice:
    """One device by its answers and notifications; its id is, for example, ``shellyplus1-a8032abe54dc``."""

    def __init__(self, device_id: str) -> None:
        self._device = Gen2Device(device_id)
        self._parts: dict[PartKey, DescribedPart] = {}
        self._notifications = f"{device_id}/events/rpc"
        self._answers = f"{CLIENT}/{device_id}/rpc"

    @property
    def id(self) -> str:
        """Its id, the key of its own description."""
        return self._device.prefix

    def record_answer(self, kind: AnswerKind, answer: Fields, size: int) -> None:
        """Replace the answer of a *kind*; *size* is in bytes."""
        self._device.record_answer(kind, answer, size)

    def add_page(self, page: Fields) -> int:
        """Add a page of the answer to ``Shelly.GetComponents``; the last page replaces the added components.

        Returns:
            The number of components on all pages so far; 0 after the last page.
        """
        start = self._device.page_start(page)
        return 0 if start is None else self._device.add_page(page, start, 0)

    def components_status(self) -> bytes:
        """Return the status of the added components, as an answer to ``Shelly.GetStatus``."""
        status = {key: component.get("status") for key, component in self._device.added.items()}
        return compact_json({"result": status}).encode(errors="replace")

    def describe(self) -> tuple[DeviceAnnounced, ...]:
        """Return its description and those of the Bluetooth devices behind it; none if nothing changed."""
        changed, gone = self._device.describe(CLIENT, "", self._device.prefix)
        if not changed and not gone:
            return ()
        described = tuple(self._device.described.values())
        self._parts = {(announced.key, part.part.id): part for announced in described for part in announced.parts}
        return described

    @property
    def stale_after(self) -> float:
        """Seconds of silence after which a sleeping device is missed; 0 for one that never sleeps."""
        if not sleeps(self._device.status):
            return 0.0
        period = to_number(as_fields(self._device.status.get("sys")).get("wakeup_period")) or _DAILY
        return _MISSED * min(period, _MAX_SILENCE_S)

    def read_notification(self, frame: bytes) -> Iterator[tuple[PartKey, Readings]]:
        """Yield the readings of each part in the notification *frame*."""
        return self._read(self._notifications, frame)

    def read_status(self, frame: bytes) -> Iterator[tuple[PartKey, Readings]]:
        """Yield the readings of each part in the answer *frame* to ``Shelly.GetStatus``."""
        return self._read(self._answers, frame)

    def calls(
        self, part: PartKey, values: Mapping[str, PlainValue], transition: float
    ) -> tuple[tuple[RpcCall, ...], Collection[str]]:
        """Return the calls that set the first of the *values* of a *part*, and the names of those that they set.

        Raises:
            RefusedError: There is no such part, it cannot do that, or the value is out of its bounds.
        """
        described = self._parts.get(part)
        if described is None:
            raise RefusedError(f"a command to {part[1][:60]!r}", "the device has no such part any more")
        assert isinstance(described.codec, WritesSeveral), "a codec made of tables"  # noqa: S101 - for the type checker
        publications, names = described.codec.write_several(values, transition=transition)
        frames = [parse_object(publication.payload) for publication in publications]
        return tuple([(str(frame["method"]), as_fields(frame.get("params"))) for frame in frames]), names

    def _read(self, topic: str, frame: bytes) -> Iterator[tuple[PartKey, Readings]]:
        for part, described in self._parts.items():
            if readings := described.codec.read(topic, frame, retained=False):
                yield part, readings


def is_setup_change(frame: Fields) -> bool:
    """Return whether *frame* reports a changed configuration, so that the answers are outdated."""
    return frame.get("method") == "NotifyEvent" and is_config_change(as_fields(frame.get("params")))


USER = "admin"
ALGORITHM = "SHA-256"

_MAX_COUNT = 10**9
_MAX_TEXT_CHARACTERS = 200


class RpcLogin:
    """Digest login with the device's password."""

    def __init__(self, password: SecretStr) -> None:
        self._password = password
        self._realm = ""
        self._nonce: str | int = ""
        self._count = 0

    @property
    def is_challenged(self) -> bool:
        """True after a challenge, so that calls can be signed."""
        return bool(self._realm)

    def accept_challenge(self, message: str) -> None:
        """Read the challenge in the *message* of an error 401.

        Raises:
            WireError: It is no challenge, or not for SHA-256.
        """
        challenge = parse_object(message)
        realm, nonce, algorithm = (challenge.get(name) for name in ("realm", "nonce", "algorithm"))
        if not (isinstance(realm, str) and 0 < len(realm) <= _MAX_TEXT_CHARACTERS):
            raise WireError("a challenge has no valid realm")
        if (
            isinstance(nonce, bool)
            or not isinstance(nonce, int | str)
            or not 0 < len(str(nonce)) <= _MAX_TEXT_CHARACTERS
        ):
            raise WireError("a challenge has no valid nonce")
        if algorithm != ALGORITHM:
            raise WireError(f"the algorithm of a challenge is not {ALGORITHM}")
        count = to_number(challenge.get("nc"))  # a text on a Wall Display
        self._realm, self._nonce = realm, nonce
        self._count = int(count) if count is not None and 0 < count < _MAX_COUNT else 1

    def sign(self) -> dict[str, object]:
        """Return the member ``auth`` of the next call; needs a challenge first."""
        count, client_nonce = self._count, secrets.token_hex(8)
        self._count += 1
        secret = _hash(USER, self._realm, self._password.get_secret_value())
        response = _hash(secret, str(self._nonce), str(count), client_nonce, "auth", _REQUEST)
        return {
            "realm": self._realm,
            "username": USER,
            "nonce": self._nonce,
            "nc": count,
            "cnonce": client_nonce,
            "response": response,
            "algorithm": ALGORITHM,
        }


def _hash(*texts: str) -> str:
    return hashlib.sha256(":".join(texts).encode()).hexdigest()


_REQUEST = _hash("dummy_method", "dummy_uri")
