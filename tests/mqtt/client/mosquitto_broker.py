"""A Mosquitto with the face that the contract suite of clients wants of a broker, and a wait for one that starts."""

import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import anyio
from tests.patience import PATIENCE
from tests.ports import reserve_port

MOSQUITTO: Final = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")

_CONNECT: Final = b"\x10\x0c\x00\x04MQTT\x04\x02\x00\x3c\x00\x00"
"""Of MQTT 3.1.1, without a name or a user; also who is refused gets an answer."""


async def until_it_answers(port: int) -> None:
    """Wait until a broker answers on *port* of this computer.

    Mosquitto listens before it works: one that is told to stop in between never ends, or ends without its sessions.
    """
    with anyio.fail_after(PATIENCE):
        while True:
            try:
                async with await anyio.connect_tcp("127.0.0.1", port) as stream:
                    await stream.send(_CONNECT)
                    await stream.receive()
                    return
            except (OSError, anyio.EndOfStream, anyio.BrokenResourceError):
                await anyio.sleep(0.01)  # another process: nothing of ours to wait for


class MosquittoBroker:
    """Mosquitto on a free port; nobody may touch what is below ``secret``.

    Args:
        credentials: Passwords by user name.
        policy: Not asked; its rule is in the list of what is allowed.
        settings: Further lines of its configuration.
    """

    host: Final = "127.0.0.1"

    def __init__(self, *, credentials: Mapping[str, str], policy: object, settings: str = "") -> None:
        del policy
        self._settings = settings
        self._folder = Path(tempfile.mkdtemp(prefix="mosquitto-"))
        self._credentials = credentials
        self._process: subprocess.Popen[bytes] | None = None
        self.port = reserve_port()

    async def __aenter__(self) -> Self:
        folder = self._folder
        (folder / "passwords").write_text("".join(f"{name}:{word}\n" for name, word in self._credentials.items()))
        (folder / "passwords").chmod(0o600)
        await anyio.run_process(["mosquitto_passwd", "-U", str(folder / "passwords")])
        rules = "".join(f"user {name}\ntopic readwrite #\ntopic deny secret/#\n" for name in self._credentials)
        (folder / "acl").write_text(rules)
        (folder / "mosquitto.conf").write_text(
            f"listener {self.port} {self.host}\nuser root\nallow_anonymous false\npassword_file {folder}/passwords\n"
            f"acl_file {folder}/acl\npersistence true\npersistence_location {folder}/\nmax_queued_messages 100000\n"
            + self._settings
        )
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.stop(abrupt=True)
        shutil.rmtree(self._folder)

    async def stop(self, *, abrupt: bool = False) -> None:
        """Stop it; *abrupt* kills it."""
        process, self._process = self._process, None
        if process is not None:
            process.kill() if abrupt else process.terminate()
            try:
                with anyio.fail_after(PATIENCE):
                    await anyio.to_thread.run_sync(process.wait, abandon_on_cancel=True)
            finally:
                process.kill()

    @contextmanager
    def frozen(self) -> Iterator[None]:
        """Keep the broker from running inside the block; its connections stand, and what comes waits."""
        process = self._process
        assert process is not None
        process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            process.send_signal(signal.SIGCONT)

    async def restart(self, *, keep_sessions: bool, abrupt: bool = False) -> None:
        """Start it anew with its sessions, which it writes down only where it is stopped in order."""
        assert keep_sessions
        del abrupt
        await self.stop()
        await self.start()

    async def until_saved(self) -> None:
        """Wait until it has written down what it knew before this call; its settings make it do so by itself."""
        file, began = self._folder / "mosquitto.db", time.time()
        with anyio.fail_after(PATIENCE):
            while not file.exists() or file.stat().st_mtime <= began:  # noqa: ASYNC110 - another process writes it
                await anyio.sleep(0.05)

    async def start(self) -> None:
        """Start it, and wait until it answers."""
        self._process = subprocess.Popen(
            [str(MOSQUITTO), "-c", str(self._folder / "mosquitto.conf")],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        await until_it_answers(self.port)
