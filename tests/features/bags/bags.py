"""Messages for bags."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from homebot.features.bags.bag_topic import BagMessage, BagTopic, qos_text
from homebot.features.bags.bag_writer import BagWriter
from homebot.features.bags.mcap_file import DamagedFileError, McapFile
from homebot.graph import QoSProfile
from homebot.messages import String
from homebot.messages.cdr import message_to_cdr
from homebot.messages.definition import definition_text
from homebot.messages.message import Message

START = 1_700_000_000_000_000_000


def topic(name: str, message_type: type[Message] = String, qos: QoSProfile | None = None) -> BagTopic:
    offered = qos_text([(qos or QoSProfile()).to_plain()])
    return BagTopic.of(name, message_type.ros_type, definition_text(message_type), offered)


CHAT = topic("/chat")


def words(count: int, size: int = 10) -> Iterator[BagMessage]:
    """Yield a text every tenth of a second, none of which can be compressed into another."""
    for number in range(count):
        data = message_to_cdr(String(data=f"{number:0{size}}"))
        yield BagMessage(CHAT, START + number * 100_000_000, data)


def whole(file: McapFile) -> list[BagMessage]:
    """Return all messages of *file* that are whole."""
    found: list[BagMessage] = []
    with suppress(DamagedFileError):
        found += file.whole_messages()
    return found


def bag_of(path: Path, count: int, size: int = 10) -> list[BagMessage]:
    written = list(words(count, size))
    with BagWriter(path) as writer:
        for message in written:
            writer.write(message)
    return written
