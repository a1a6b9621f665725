"""Backups that the page downloads in parts, with the content of ``homebot backup``."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, final

from anyio import to_thread

from homebot.devices.names import COPY_FILES
from homebot.errors import HomebotError, UsageError
from homebot.features.page.setup_messages import BackupResponse
from homebot.messages.std_srvs import Trigger, TriggerRequest

if TYPE_CHECKING:
    from collections.abc import Callable

    from homebot.features.page.setup_messages import BackupRequest
    from homebot.graph import Node

MAX_PART_BYTES: Final = 1024 * 1024
_PATIENCE_S: Final = 120.0
_FILE: Final = "page-backup.tar"


class _Made(NamedTuple):
    file: Path
    name: str
    size: int
    left_out: tuple[str, ...]


@final
class Backups:
    """The one backup that is being downloaded, a file beside the data until its last part is read.

    Args:
        file: Returns the file of the configuration; called in a thread.
    """

    def __init__(self, node: Node, file: Callable[[], Path]) -> None:
        self._node = node
        self._file = file
        self._made: _Made | None = None

    async def get(self, request: BackupRequest) -> BackupResponse:
        """Return a part of the backup."""
        try:
            if not request.offset:
                copies = await self._node.create_client(Trigger, COPY_FILES).call(TriggerRequest(), _PATIENCE_S)
                if not copies.success:
                    raise UsageError(copies.message)
                self._made = await to_thread.run_sync(self._make, Path(copies.message))
            return await to_thread.run_sync(self._part, request.offset)
        except (HomebotError, OSError) as exc:
            return BackupResponse(success=False, message=str(exc))

    def _make(self, copies: Path) -> _Made:
        from homebot.cli.commands.backup import write_backup  # noqa: PLC0415 - few runs make one

        target = copies.parent / _FILE
        target.unlink(missing_ok=True)
        manifest = write_backup(self._file(), copies, target)
        day = datetime.fromisoformat(manifest.made).date()
        return _Made(target, f"{manifest.home or 'home'}-{day}.tar", target.stat().st_size, manifest.left_out)

    def _part(self, offset: int) -> BackupResponse:
        made = self._made
        if made is None or offset >= made.size:
            raise UsageError(f"no backup has a byte {offset}; begin with 0, which makes one")
        with made.file.open("rb") as file:
            file.seek(offset)
            data = file.read(MAX_PART_BYTES)
        if offset + len(data) >= made.size:
            made.file.unlink()
            self._made = None
        return BackupResponse(
            success=True, message="", name=made.name, size=made.size, data=data, left_out=made.left_out
        )
