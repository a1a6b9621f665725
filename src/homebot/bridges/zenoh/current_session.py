"""The session of ``[ros]``, as gateways find it."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from homebot.bridges.zenoh.session import ZenohSession


@final
class CurrentSession:
    """The session that is open now; another task makes its calls. None while there is none."""

    session: ZenohSession | None = None
