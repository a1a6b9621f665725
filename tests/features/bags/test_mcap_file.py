"""MCAP files that were cut off, damaged or written by others."""

import struct
import tracemalloc
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from mcap.data_stream import RecordBuilder
from mcap.reader import SeekingReader
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer
from tests.features.bags.bags import CHAT, START, bag_of, whole
from zstandard import ZstdCompressor

from homebot.errors import UsageError
from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_topic import BagMessage
from homebot.features.bags.bag_writer import BagWriter
from homebot.features.bags.mcap_file import DamagedFileError, McapFile


def test_a_file_that_was_cut_off_gives_what_is_whole(tmp_path: Path) -> None:
    written = bag_of(tmp_path / "whole.mcap", 4000, 300)
    intact = (tmp_path / "whole.mcap").read_bytes()
    cut = McapFile(tmp_path / "cut.mcap")
    cut.path.write_bytes(intact[: len(intact) * 6 // 10])
    for read in (cut.content, lambda: list(cut.messages())):
        with pytest.raises(DamagedFileError, match=r"homebot bag recover .*cut.mcap NEW` keeps what is whole"):
            read()
    found = whole(cut)
    assert 1000 < len(found) < 4000
    assert found == written[: len(found)]


@pytest.mark.parametrize("length", [8, 9, 36])
def test_a_file_that_was_cut_off_after_its_first_bytes_is_called_so(tmp_path: Path, length: int) -> None:
    """A disk that is full from the start leaves no more than the magic bytes."""
    bag_of(tmp_path / "whole.mcap", 3)
    cut = McapFile(tmp_path / "cut.mcap")
    cut.path.write_bytes((tmp_path / "whole.mcap").read_bytes()[:length])
    for read in (cut.content, lambda: list(cut.messages())):
        with pytest.raises(DamagedFileError, match="was cut off or is damaged"):
            read()


def test_any_damage_is_an_error_in_words_and_never_a_wrong_message(tmp_path: Path) -> None:
    """Bytes are changed, dropped and put in anywhere; checksums find it."""
    written = bag_of(tmp_path / "whole.mcap", 300)
    intact = (tmp_path / "whole.mcap").read_bytes()
    random = Random(1)  # noqa: S311 - the same each time
    for _ in range(300):
        at = random.randrange(len(intact))
        piece = random.choice((b"", random.randbytes(1), random.randbytes(9)))
        damaged = McapFile(tmp_path / "damaged.mcap")
        damaged.path.write_bytes(intact[:at] + piece + intact[at + 1 :])
        found: list[BagMessage] = []
        with suppress(UsageError):
            found += damaged.whole_messages()
        for read in (damaged.content, lambda: list(damaged.messages())):  # noqa: B023 - called at once
            with suppress(UsageError):
                read()
        rest = iter([one.data for one in written])
        assert all(one.data in rest for one in found), "in the order in which they were written"


@pytest.mark.parametrize("text", [b"hello\n", b"{}", b"\x89PNG\r\n\x1a\n", b"notes of a day " * 9])
@pytest.mark.parametrize("is_cut", [False, True])
def test_a_file_that_begins_as_no_mcap_file_is_called_none(tmp_path: Path, text: bytes, is_cut: bool) -> None:  # noqa: FBT001 - a parameter of a test
    (tmp_path / "other").write_bytes(text)
    other = McapFile(tmp_path / "other")
    for read in (other.content, lambda: list(other.whole_messages() if is_cut else other.messages())):
        with pytest.raises(UsageError, match="other is not an MCAP file"):
            read()


@pytest.mark.parametrize("text", [b"", b"{}", b"\x89PNG\r\n\x1a\n"])
def test_another_file_is_none(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "other").write_bytes(text)
    with pytest.raises(UsageError, match=r"other (is not an MCAP file|was cut off or is damaged)"):
        McapFile(tmp_path / "other").content()


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="day cannot be read: No such file or directory"):
        McapFile(tmp_path / "day").content()


def test_a_topic_in_an_encoding_that_homebot_does_not_read_is_kept_and_the_others_are_read(tmp_path: Path) -> None:
    """As rosbag2 records types in IDL, and types of which it finds no text."""
    idl = replace(CHAT, name="/idl", encodings=("cdr", "ros2idl"))
    unknown = replace(CHAT, name="/unknown", definition="", encodings=("cdr", ""))
    written = [BagMessage(one, START, b"\x00\x01\x00\x00") for one in (CHAT, idl, unknown)]
    for path in (tmp_path / "first", tmp_path / "second"):
        with BagWriter(path) as writer:
            for message in written:
                writer.write(message)
        (file,) = bag_files(path)
        assert file.content().counts == dict.fromkeys((CHAT, idl, unknown), 1)
        written = list(file.whole_messages())


def test_a_damaged_chunk_costs_itself_alone(tmp_path: Path) -> None:
    """Whether its content, its length or the channel that the others need is damaged, or the index too is missing."""
    written = bag_of(tmp_path / "whole.mcap", 4000, 300)
    intact = (tmp_path / "whole.mcap").read_bytes()
    with (tmp_path / "whole.mcap").open("rb") as file:
        summary = SeekingReader(file).get_summary()
    assert summary is not None
    starts = [chunk.chunk_start_offset for chunk in summary.chunk_indexes]
    end = starts[-1] + summary.chunk_indexes[-1].chunk_length
    for at, content in ((starts[0] + 500, intact), (starts[1] + 5, intact), (starts[1] + 500, intact[:end])):
        damaged = McapFile(tmp_path / "damaged.mcap")
        damaged.path.write_bytes(content[:at] + b"\x7f\x7f" + content[at + 2 :])
        found = whole(damaged)
        assert len(found) > 4000 * (len(starts) - 2) // len(starts)
        assert found[-1] == written[-1]


def nested(depth: int) -> bytes:
    """Return a chunk in which, behind zeros, is a chunk, and so on."""
    chunk = b""
    for _ in range(depth):
        size = 60 * 1024**2
        data = ZstdCompressor().compress(struct.pack("<BQ", 0x7E, size) + bytes(size) + chunk)
        record = RecordBuilder()
        Chunk("zstd", data, START, START, 0, size).write(record)
        chunk = record.end()  # type: ignore[no-untyped-call]
    return chunk


@pytest.mark.parametrize(
    ("compression", "size", "is_packed", "count"),
    [
        (CompressionType.ZSTD, 300, False, 0),
        (CompressionType.LZ4, 300, False, 0),
        (CompressionType.ZSTD, 60, True, 6),
        (CompressionType.NONE, 300, True, 0),
    ],
    ids=["a chunk, zstd", "a chunk, lz4", "messages that are compressed in a chunk", "a message that is compressed"],
)
def test_a_small_file_takes_no_large_memory(
    tmp_path: Path,
    compression: CompressionType,
    size: int,
    is_packed: bool,  # noqa: FBT001 - a parameter of a test
    count: int,
) -> None:
    message = bytes(size * 1024**2)
    if is_packed:
        message = ZstdCompressor().compress(message)
    bomb = McapFile(tmp_path / "bomb.mcap")
    with bomb.path.open("wb") as file:
        writer = Writer(file, 400 * 1024**2, compression)
        writer.start()
        channel = writer.register_channel("/bomb", "cdr", writer.register_schema("std_msgs/msg/String", "ros2msg", b""))
        for number in range(max(count, 1)):
            writer.add_message(channel, START + number, message, START)
        writer.finish()  # type: ignore[no-untyped-call]
    del message
    assert_small(bomb, count)


def test_chunks_in_chunks_take_no_large_memory(tmp_path: Path) -> None:
    bomb = McapFile(tmp_path / "bomb.mcap")
    bomb.path.write_bytes(MCAP0_MAGIC + nested(6) + bytes(100))
    assert_small(bomb, 0)


def assert_small(bomb: McapFile, count: int) -> None:
    """Check that *bomb* gives *count* messages, or else an error, and that reading it takes little memory."""
    for read in (bomb.messages, bomb.whole_messages):
        tracemalloc.start()
        try:
            with nullcontext() if count else pytest.raises(DamagedFileError):
                assert sum(1 for _ in read()) == count
            assert tracemalloc.get_traced_memory()[1] < 150 * 1024**2
        finally:
            tracemalloc.stop()
