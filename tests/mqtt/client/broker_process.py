"""The embedded broker in a process of its own, so that it can be killed; with the face of `MosquittoBroker`."""

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import anyio
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.log import configure_logging
from homebot.mqtt.broker import Broker

_ROOT: Final = Path(__file__).parents[3]
_LISTENS: Final = b"it listens\n"


class BrokerProcess:
    """The embedded broker on a free port; a killed one has forgotten everything, as nothing of it is on disk.

    Args:
        credentials: The password of one user.
    """

    host: Final = "127.0.0.1"

    def __init__(self, *, credentials: Mapping[str, str]) -> None:
        ((self._user, self._password),) = credentials.items()
        self._process: subprocess.Popen[bytes] | None = None
        self.port = reserve_port()

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.stop(abrupt=True)

    async def stop(self, *, abrupt: bool = False) -> None:
        """Stop it; *abrupt* kills it."""
        process, self._process = self._process, None
        if process is not None:
            process.kill() if abrupt else process.terminate()
            await anyio.to_thread.run_sync(process.wait)
            assert process.stdout is not None
            process.stdout.close()

    async def start(self) -> None:
        """Start it, and wait until it listens."""
        command = [sys.executable, "-m", __name__, str(self.port), self._user, self._password]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, cwd=_ROOT)
        assert self._process.stdout is not None
        with anyio.fail_after(PATIENCE):
            assert await anyio.to_thread.run_sync(self._process.stdout.readline) == _LISTENS


async def _serve(port: int, user: str, password: str) -> None:
    async with Broker(port=port, credentials={user: password}):
        sys.stdout.write(_LISTENS.decode())
        sys.stdout.flush()
        await anyio.sleep_forever()


if __name__ == "__main__":
    configure_logging(level="error")
    anyio.run(_serve, int(sys.argv[1]), sys.argv[2], sys.argv[3])
