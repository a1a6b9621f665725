"""One MCAP file as rosbag2 writes it. The only file that imports ``mcap``.

Source: MCAP specification and its registries of profiles and encodings, https://mcap.dev/spec; rosbag2,
``mcap_storage.cpp``.
"""

import heapq
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from itertools import count, islice
from pathlib import Path
from typing import IO, Final, NamedTuple, TypeAlias, final

from lz4.frame import LZ4FrameDecompressor
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.opcode import Opcode
from mcap.reader import FOOTER_SIZE, SeekingReader
from mcap.records import Channel, Chunk, ChunkIndex, Message, Schema
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC, Writer
from zstandard import ZstdDecompressor, ZstdError, frame_content_size

from homebot.errors import UsageError
from homebot.features.bags.bag_topic import BagMessage, BagTopic
from homebot.version import __version__

CHUNK: Final = 256 * 1024

MAX_UNPACKED_BYTES: Final = 64 * 1024**2
"""Bytes that a chunk, or a message that is compressed by itself, unpacks to: rosbag2 writes chunks of 4 MiB at most,
or of one message. A ratio says nothing here, as an empty map of a robot is all zeros."""

_MAX_WAITING_BYTES: Final = 8 * MAX_UNPACKED_BYTES
"""The same for chunks whose times overlap."""

_HEAD: Final = struct.Struct("<BQ")

_COMPRESSED: Final = b"\x28\xb5\x2f\xfd"
"""The first bytes of a message that rosbag2 compressed by itself; CDR begins with 00."""

_BROKEN: Final = (McapError, ZstdError, struct.error, ValueError, KeyError, OverflowError, MemoryError, RuntimeError)


class DamagedFileError(UsageError):
    """A file was cut off, or is damaged."""


class McapContent(NamedTuple):
    """A file's messages, counted by topic; the times are in nanoseconds since 1970."""

    counts: dict[BagTopic, int]
    start: int
    end: int


_Record: TypeAlias = Schema | Channel | Message | Chunk


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
            encoding, schema = topic.encodings
            kind = topic.ros_type, schema, topic.definition
            if kind not in self._schemas:
                self._schemas[kind] = self._writer.register_schema(topic.ros_type, schema, topic.definition.encode())
            facts = {"offered_qos_profiles": topic.qos, "topic_type_hash": topic.type_hash}
            channel = self._channels[topic] = self._writer.register_channel(
                topic.name, encoding, self._schemas[kind], facts
            )
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
        with self._open() as file:
            summary = _summary(file)
            if summary.statistics is None:
                raise EndOfFile("it has no index")
            statistics = summary.statistics
            counts = {
                _topic(summary.schemas.get(channel.schema_id), channel): statistics.channel_message_counts.get(
                    number, 0
                )
                for number, channel in summary.channels.items()
            }
            return McapContent(counts, statistics.message_start_time, statistics.message_end_time)

    def messages(self) -> Iterator[BagMessage]:
        """Yield its messages in order of time; errors as for :meth:`content`."""
        with self._open() as file:
            summary, numbers = _summary(file), count()
            waiting: list[tuple[int, int, BagMessage]] = []
            for chunk in sorted(summary.chunk_indexes, key=lambda chunk: chunk.message_start_time):
                while waiting and waiting[0][0] < chunk.message_start_time:
                    yield _whole(heapq.heappop(waiting)[2])
                for message in _messages(_chunk_records(file, chunk), summary):
                    heapq.heappush(waiting, (message.at, next(numbers), message))
                if sum(len(message.data) for *_, message in waiting) > _MAX_WAITING_BYTES:
                    raise EndOfFile("too many of its chunks are of one time")
            if not summary.chunk_indexes:
                file.seek(len(MCAP0_MAGIC))
                waiting = [
                    (message.at, next(numbers), message) for message in _messages(_records(file, is_file=True), summary)
                ]
            for *_, message in sorted(waiting):
                yield _whole(message)

    def whole_messages(self) -> Iterator[BagMessage]:
        """Yield the messages of all chunks that are whole, as they were written; then errors as :meth:`content`."""
        with self._open() as file:
            summary, problem = Summary(), None
            with suppress(*_BROKEN):
                summary = _summary(file)
            in_file = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
            chunks: Iterator[ChunkIndex | _Record] = iter(in_file)
            if not summary.chunk_indexes:
                file.seek(len(MCAP0_MAGIC))
                chunks = _records(file, is_file=True)
            while True:
                try:
                    if (chunk := next(chunks, None)) is None:
                        break
                    records = _chunk_records(file, chunk) if isinstance(chunk, ChunkIndex) else iter((chunk,))
                    messages = list(_messages(records, summary))
                except _BROKEN as exc:  # the next one may be whole; after records that have no end nothing comes
                    problem = exc
                    continue
                for message in messages:
                    try:
                        unpacked = _whole(message)
                    except _BROKEN as exc:
                        problem = exc
                    else:
                        yield unpacked
            if problem is not None:
                raise problem

    @contextmanager
    def _open(self) -> Iterator[IO[bytes]]:
        try:
            with self.path.open("rb") as file:
                # The library looks at the end first.
                if not MCAP0_MAGIC.startswith(start := file.read(len(MCAP0_MAGIC))):
                    raise InvalidMagic(start)
                if len(file.read(FOOTER_SIZE)) < FOOTER_SIZE:
                    raise EndOfFile("it has no footer")
                file.seek(0)
                yield file
        except InvalidMagic as exc:
            raise UsageError(f"{self.path} is not an MCAP file") from exc
        except _BROKEN as exc:
            rescue = f"`homebot bag recover {self.path} NEW` keeps what is whole"
            raise DamagedFileError(f"{self.path} was cut off or is damaged; {rescue}") from exc
        except OSError as exc:
            raise UsageError(f"{self.path} cannot be read: {exc.strerror or exc}") from exc


def _summary(file: IO[bytes]) -> Summary:
    size = file.seek(0, 2)
    file.seek(0)
    if (summary := SeekingReader(file, record_size_limit=size).get_summary()) is None:
        raise EndOfFile("it has no index")
    return summary


def _records(file: IO[bytes], *, is_file: bool) -> Iterator[_Record]:
    """Yield the useful ones of the next records, up to the footer if that *is_file*; only there are chunks."""
    while head := file.read(_HEAD.size):
        opcode, length = _HEAD.unpack(head)
        at = file.tell()
        if length > file.seek(0, 2) - at:  # before any memory is taken for it
            raise EndOfFile("a record is cut off")
        file.seek(at)
        stream = ReadDataStream(BytesIO(file.read(length)))
        match opcode:
            case Opcode.FOOTER:
                return
            case Opcode.MESSAGE:
                yield Message.read(stream, length)
            case Opcode.SCHEMA:
                yield Schema.read(stream)
            case Opcode.CHANNEL:
                yield Channel.read(stream)
            case Opcode.CHUNK if is_file:
                yield Chunk.read(stream)
    if is_file:
        raise EndOfFile("it has no footer")


def _chunk_records(file: IO[bytes], chunk: ChunkIndex) -> Iterator[_Record]:
    """Yield the chunk itself."""
    file.seek(chunk.chunk_start_offset)
    yield from islice(_records(file, is_file=True), 1)


def _messages(records: Iterator[_Record], summary: Summary) -> Iterator[BagMessage]:
    """Yield the messages among *records* and in their chunks, as they are packed; *summary* gets their topics.

    Raises:
        Exception: One of ``_BROKEN``.
    """
    for record in records:
        match record:
            case Schema():
                summary.schemas[record.id] = record
            case Channel():
                summary.channels[record.id] = record
            case Chunk():
                data = _unpack(record.data, record.compression)
                if record.uncompressed_crc not in {0, zlib.crc32(data)}:
                    raise EndOfFile("a chunk has another checksum")
                yield from _messages(_records(BytesIO(data), is_file=False), summary)
            case Message():
                channel = summary.channels[record.channel_id]
                yield BagMessage(_topic(summary.schemas.get(channel.schema_id), channel), record.log_time, record.data)


def _whole(message: BagMessage) -> BagMessage:
    """Unpack *message* if it is compressed by itself: one at a time, as each may be large."""
    is_packed = message.data.startswith(_COMPRESSED)
    return message._replace(data=_unpack(message.data, "zstd")) if is_packed else message


def _unpack(data: bytes, compression: str) -> bytes:
    match compression:
        case "zstd":  # which believes the size in a frame, and takes as much memory
            if frame_content_size(data) <= MAX_UNPACKED_BYTES:
                return ZstdDecompressor().decompress(data, max_output_size=MAX_UNPACKED_BYTES)
        case "lz4":
            unpacker = LZ4FrameDecompressor()
            unpacked: bytes = unpacker.decompress(data, MAX_UNPACKED_BYTES)
            if unpacker.eof:
                return unpacked
        case _:
            return data
    raise EndOfFile(f"a chunk unpacks to more than {MAX_UNPACKED_BYTES:,} bytes")


def _topic(schema: Schema | None, channel: Channel) -> BagTopic:
    return BagTopic(
        channel.topic,
        schema.name if schema else "",
        schema.data.decode() if schema else "",
        channel.metadata.get("topic_type_hash", ""),
        channel.metadata.get("offered_qos_profiles", ""),
        (channel.message_encoding, schema.encoding if schema else ""),
    )
