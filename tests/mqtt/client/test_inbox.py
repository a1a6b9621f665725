"""The bounded store between link and reader."""

from __future__ import annotations

import anyio
import pytest
from anyio import wait_all_tasks_blocked

from homebot.errors import LinkError
from homebot.mqtt.client.receiver import Inbox
from homebot.mqtt.message import MqttMessage


def message(name: str, qos: int = 0) -> MqttMessage:
    return MqttMessage("t", name.encode(), qos)


def open_inbox(max_messages: int = 3, max_bytes: int = 1000) -> Inbox:
    inbox = Inbox(max_messages, max_bytes)
    inbox.reopen(resumed=False)
    return inbox


def names(messages: list[MqttMessage]) -> list[str]:
    return [message.payload.decode() for message in messages]


async def test_everything_that_is_there_comes_in_one_batch() -> None:
    inbox = open_inbox()
    for name in "abc":
        inbox.put(message(name))
    assert names(await inbox.receive()) == ["a", "b", "c"]


async def test_when_full_the_oldest_message_of_qos_0_goes() -> None:
    inbox = open_inbox(3)
    for name in "abcde":
        inbox.put(message(name))
    assert names(await inbox.receive()) == ["c", "d", "e"]
    assert inbox.dropped == 2


async def test_messages_of_qos_1_and_2_are_never_dropped() -> None:
    inbox = open_inbox(2)
    for name, qos in zip("abcdef", (1, 0, 2, 0, 1, 0), strict=True):
        inbox.put(message(name, qos))
    assert names(await inbox.receive()) == ["a", "c", "d", "e", "f"]
    assert inbox.dropped == 1


async def test_bytes_are_bounded_too_but_one_message_always_fits() -> None:
    inbox = open_inbox(100, 10)
    inbox.put(message("12345"))
    inbox.put(message("x" * 50))
    assert names(await inbox.receive()) == ["x" * 50]
    assert inbox.dropped == 1


async def test_the_bounds_start_anew_after_a_take() -> None:
    inbox = open_inbox(2)
    for batch in ("ab", "cd"):
        for name in batch:
            inbox.put(message(name))
        assert names(await inbox.receive()) == list(batch)
    assert inbox.dropped == 0


async def test_a_reader_is_woken_by_the_first_message() -> None:
    inbox = open_inbox()
    got: list[str] = []

    async def read() -> None:
        got.extend(names(await inbox.receive()))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await wait_all_tasks_blocked()
        inbox.put(message("a"))
    assert got == ["a"]


async def test_a_waiting_reader_is_told_when_nothing_more_will_come() -> None:
    inbox = open_inbox()

    async def read() -> None:
        with pytest.raises(LinkError, match="cable"):
            await inbox.receive()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await wait_all_tasks_blocked()
        inbox.end(LinkError("cable"))


async def test_what_is_there_can_be_read_after_the_end() -> None:
    inbox = open_inbox()
    inbox.put(message("a"))
    inbox.end(LinkError("cable"))
    assert names(await inbox.receive()) == ["a"]
    with pytest.raises(LinkError):
        await inbox.receive()


async def test_before_the_first_link_there_is_nothing_to_wait_for() -> None:
    with pytest.raises(LinkError, match="not connected"):
        await Inbox(1, 1).receive()


async def test_a_resumed_session_repeats_qos_1_so_waiting_copies_go() -> None:
    inbox = open_inbox()
    for name, qos in zip("abc", (0, 1, 2), strict=True):
        inbox.put(message(name, qos))
    inbox.reopen(resumed=True)
    assert names(await inbox.receive()) == ["a", "c"]


async def test_a_lost_session_repeats_nothing_so_all_stays() -> None:
    inbox = open_inbox()
    for name, qos in zip("abc", (0, 1, 2), strict=True):
        inbox.put(message(name, qos))
    inbox.reopen(resumed=False)
    assert names(await inbox.receive()) == ["a", "b", "c"]


async def test_a_cancelled_reader_does_not_disturb_the_next() -> None:
    inbox = open_inbox()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(inbox.receive)
        await wait_all_tasks_blocked()
        tasks.cancel_scope.cancel()
    inbox.put(message("a"))
    assert names(await inbox.receive()) == ["a"]
