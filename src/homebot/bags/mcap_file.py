"""One MCAP file as rosbag2 writes it. The only file that imports ``mcap``.

Source: MCAP specification and its registries of profiles and encodings, https://mcap.dev/spec; rosbag2,
``mcap_storage.cpp``.
"""

import struct
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final, NamedTuple, final

from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.reader import FOOTER_SIZE, NonSeekingReader, SeekingReader
from mcap.records import Channel, Schema
from mcap.writer import MCAP0_MAGIC, Writer
from zstandard import ZstdDecompressor, ZstdError

from homebot.bags.bag_topic import BagMessage, BagTopic
from homebot.errors import UsageError
from homebot.version import __version__

__all__ = ["CHUNK", "DamagedFileError", "McapContent", "McapFile", "McapWriter"]

CHUNK: Final = 256 * 1024

_LARGEST: Final = 1024**3
"""Bytes of a record that a reader believes."""

_COMPRESSED: Final = b"\x28\xb5\x2f\xfd"
"""The first bytes of a message that rosbag2 compressed by itself; CDR begins with 00."""

_BROKEN: Final = (McapError, ZstdError, struct.error, ValueError, KeyError, OverflowError, MemoryError)


class DamagedFileError(UsageError):
    """A file was cut off, or is damaged."""


class McapContent(NamedTuple):
    """A file's messages, counted by topic; the times are in nanoseconds since 1970."""

    counts: dict[BagTopic, int]
    start: int
    end: int


@final
class McapWriter:
    """Writes into *file*, which it closes.

    Args:
        chunk: Bytes that are compressed, and lost if the file is cut off, together.

    Attributes:
        counts: Its messages by topic.
        start, end: The times of the earliest and the latest of them.
    """

    def __init__(self, file: IO[bytes], chunk: int = CHUNK) -> None:
        self.name = Path(file.name).name
        self.counts: Counter[BagTopic] = Counter()
        self.start = self.end = 0
        self._file = file
        self._writer = Writer(file, chunk)
        self._writer.start("ros2", f"homebot {__version__}")
        self._schemas: dict[tuple[str, str, str], int] = {}
        self._channels: dict[BagTopic, int] = {}

    @property
    def size(self) -> int:
        """Bytes in the file, without those that wait to be compressed."""
        return self._file.tell()

    def write(self, message: BagMessage) -> None:
        """Add *message*.

        Raises:
            OSError: The disk is full or missing.
        """
        topic, at, data = message
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._channel(topic)
        self.start, self.end = (min(self.start, at), max(self.end, at)) if self.counts else (at, at)
        self.counts[topic] += 1
        self._writer.add_message(channel, at, data, at, self.counts[topic])

    def flush(self) -> None:
        """Give everything to the operating system."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self, metadata: str) -> None:
        """Write the *metadata* of the bag and the index."""
        with self._file:
            self._writer.add_metadata("rosbag2", {"serialized_metadata": metadata})
            self._writer.finish()  # type: ignore[no-untyped-call]

    def _channel(self, topic: BagTopic) -> int:
        encoding, schema = topic.encodings
        kind = topic.ros_type, schema, topic.definition
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(topic.ros_type, schema, topic.definition.encode())
        facts = {"offered_qos_profiles": topic.qos, "topic_type_hash": topic.type_hash}
        return self._writer.register_channel(topic.name, encoding, self._schemas[kind], facts)


@final
class McapFile:
    """A file to read."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def content(self) -> McapContent:
        """Return the content of its index.

        Raises:
            DamagedFileError: It was cut off or damaged.
            UsageError: It cannot be read, or is no MCAP file.
        """
        with self._opened() as file:
            summary = SeekingReader(file, record_size_limit=_LARGEST).get_summary()
            if summary is None or summary.statistics is None:
                raise EndOfFile("it has no index")
            found = summary.statistics
            counts = {
                _topic(summary.schemas.get(channel.schema_id), channel): found.channel_message_counts.get(number, 0)
                for number, channel in summary.channels.items()
            }
            return McapContent(counts, found.message_start_time, found.message_end_time)

    def messages(self, *, is_cut: bool = False) -> Iterator[BagMessage]:
        """Yield its messages in order of time; errors as for :meth:`content`.

        Args:
            is_cut: Whether to yield them as they were written, all that are whole before the error.
        """
        with self._opened() as file:
            reader = (NonSeekingReader if is_cut else SeekingReader)(file, True, (), _LARGEST)  # noqa: FBT003 - its CRCs
            for schema, channel, message in reader.iter_messages(log_time_order=not is_cut):
                data = message.data
                if data.startswith(_COMPRESSED):
                    data = ZstdDecompressor().decompress(data)
                yield BagMessage(_topic(schema, channel), message.log_time, data)

    @contextmanager
    def _opened(self) -> Iterator[IO[bytes]]:
        try:
            with self.path.open("rb") as file:
                _check_start(file)
                yield file
        except InvalidMagic as exc:
            raise UsageError(f"{self.path} is not an MCAP file") from exc
        except _BROKEN as exc:
            rescue = f"`homebot bag recover {self.path} NEW` keeps what is whole"
            raise DamagedFileError(f"{self.path} was cut off or is damaged; {rescue}") from exc
        except OSError as exc:
            raise UsageError(f"{self.path} cannot be read: {exc.strerror or exc}") from exc


def _check_start(file: IO[bytes]) -> None:
    """Raise an error if *file* begins as no MCAP file or is too short; the library looks at the end first."""
    if not MCAP0_MAGIC.startswith(start := file.read(len(MCAP0_MAGIC))):
        raise InvalidMagic(start)
    if len(file.read(FOOTER_SIZE)) < FOOTER_SIZE:
        raise EndOfFile("it has no footer")
    file.seek(0)


def _topic(schema: Schema | None, channel: Channel) -> BagTopic:
    return BagTopic(
        channel.topic,
        schema.name if schema else "",
        schema.data.decode() if schema else "",
        channel.metadata.get("topic_type_hash", ""),
        channel.metadata.get("offered_qos_profiles", ""),
        (channel.message_encoding, schema.encoding if schema else ""),
    )
