"""Isolation of parts of the program, so that the failure of one does not end others.

Python ends a task by raising ``CancelledError`` in it, and a program by ``SystemExit``. But ``await task`` also raises
the former if *task* was cancelled elsewhere, and any library may call ``sys.exit()``. These functions tell the two
apart where the code of one part runs on behalf of the whole: an end of the task itself passes, everything else becomes
a crash of that part.
"""

import asyncio
import math
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from traceback import walk_tb
from types import CoroutineType, FrameType
from typing import TypeAlias

import anyio

from homebot.errors import AbortError, ExitError, HomebotError, LinkError, PeerError


@contextmanager
def isolated(owner: str) -> Iterator[None]:
    """Let the block, the entire body of a task in a task group, only fail with ordinary errors.

    A task group treats any task that ends in a CancelledError as cancelled and silently ends the others too.

    Raises:
        AbortError: The block raised a cancellation although its task is not being cancelled, or a GeneratorExit.
        ExitError: The block raised SystemExit.
    """
    task = asyncio.current_task()
    try:
        yield
    except BaseException as exc:
        if is_end_of(task, exc):
            raise
        crash = crash_of(owner, exc)
        if crash is exc:
            raise
        raise crash from exc
    if task is not None and task.cancelling() and not is_cancelled():
        raise crash_of(owner, asyncio.CancelledError())  # by itself, with its last step


async def run_as(owner: str, function: Callable[[], Awaitable[None]]) -> None:
    """Await *function* as the entire body of a task in a task group; see :func:`isolated`."""
    with isolated(owner):
        await function()


def is_cancelled() -> bool:
    """Return whether the current task is being cancelled by a cancel scope around the caller.

    Tasks of our task groups end in no other way, so that any other CancelledError in them is a stray one.
    """
    return anyio.current_effective_deadline() == -math.inf


def is_end_of(task: asyncio.Task[object] | None, error: BaseException) -> bool:
    """Return whether *error* is meant to end *task*, which ran the code that raised it."""
    if isinstance(error, asyncio.CancelledError):
        return is_cancelled()
    return isinstance(error, GeneratorExit) and _is_thrown_away(task)


def _is_thrown_away(task: asyncio.Task[object] | None) -> bool:
    """Return whether *task* is not the current one, so that its coroutine is being closed from outside."""
    try:
        return asyncio.current_task() is not task
    except RuntimeError:  # no running event loop
        return True


def uncancel() -> None:
    """Revoke cancellations of the current task that no cancel scope made."""
    task = asyncio.current_task()
    while task is not None and task.cancelling():
        task.uncancel()


def crash_of(owner: str, error: BaseException) -> Exception:
    """Return *error* of *owner*'s code as an exception that does not end other components.

    An exception is returned unchanged; in a group only the dangerous members are replaced.

    Raises:
        KeyboardInterrupt: *error* is or contains one, which is meant for the whole program.
    """
    if isinstance(error, Exception):
        return error
    if isinstance(error, KeyboardInterrupt):
        raise error
    if isinstance(error, BaseExceptionGroup):
        return ExceptionGroup(error.message, [crash_of(owner, exception) for exception in error.exceptions])
    crash = ExitError(owner, error) if isinstance(error, SystemExit) else AbortError(owner, error)
    crash.__cause__ = error
    return crash


def first_cause(error: BaseException) -> BaseException:
    """Return the first error in the exception groups of *error*."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


@contextmanager
def ungrouped(*kinds: type[HomebotError]) -> Iterator[None]:
    """Raise the first error of *kinds*, by default :class:`LinkError` or :class:`PeerError`, in place of its group.

    A group with any other error is raised unchanged.
    """
    try:
        yield
    except BaseExceptionGroup as group:
        known, others = group.split(kinds or (LinkError, PeerError))
        if known is None or others is not None:
            raise
        raise first_cause(known) from group


def only_cause(group: BaseExceptionGroup[BaseException]) -> BaseException | None:
    """Return the only exception in *group*, nested groups included, or None if there are several."""
    while len(group.exceptions) == 1:
        only = group.exceptions[0]
        if not isinstance(only, BaseExceptionGroup):
            return only
        group = only
    return None


def error_text(error: BaseException) -> str:
    """Return the text of the first error in the exception groups of *error*."""
    cause = first_cause(error)
    text = str(cause)
    return f"{type(cause).__name__}: {text}" if text else type(cause).__name__


Place: TypeAlias = tuple[type[BaseException], tuple[tuple[str, int], ...]]
"""An error's class, and the file and line of each call in its traceback."""


def place_of(error: BaseException) -> Place:
    """Return the place of *error*."""
    calls = ((frame.f_code.co_filename, line) for frame, line in walk_tb(error.__traceback__))
    return type(error), tuple(calls)


def frames_of(waits: object) -> list[FrameType]:
    """Return the frames of a waiting coroutine, outermost first."""
    frames: list[FrameType] = []
    while isinstance(waits, CoroutineType):
        frames += [waits.cr_frame] if waits.cr_frame else []
        waits = waits.cr_await
    return frames
