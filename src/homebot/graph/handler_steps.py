"""A handler's coroutine of which the first step may have been taken by hand."""

from __future__ import annotations

import operator
from collections.abc import Callable, Coroutine, Generator
from inspect import CO_COROUTINE
from opcode import opmap
from types import FunctionType, MethodType
from typing import Any, Final, TypeAlias, final

__all__ = ["IS_DUE", "NOT_BEGUN", "Handling", "RemainingSteps", "may_wait"]

Handling: TypeAlias = Coroutine[object, object, object]
"""A handler at work."""

NOT_BEGUN: Final = object()
"""In the place of what a coroutine waits for: its first step is still to be taken."""

IS_DUE: Final = object()
"""Likewise: what it waited for has come, so that it goes on at once."""

_AWAIT = opmap["SEND"]
"""The instruction that every ``await``, ``async with`` and ``async for`` is compiled to."""


def may_wait(callback: object) -> bool:
    """Return whether what *callback* returns may wait; it cannot where it is a coroutine function without an await."""
    function = callback.__func__ if isinstance(callback, MethodType) else callback
    if not isinstance(function, FunctionType) or not function.__code__.co_flags & CO_COROUTINE:
        return True
    return _AWAIT in function.__code__.co_code[::2]


@final
class RemainingSteps:
    """The rest of a coroutine, to be awaited in the task in which it took its first step.

    Args:
        coroutine: The coroutine.
        waits_for: What its first step waits for, NOT_BEGUN or IS_DUE.
        run: Calls a function with arguments, in the context that the coroutine's steps run in.
        error: What to throw into it first, instead of waiting.

    Attributes:
        is_closed: Whether it was thrown away from outside, which is no GeneratorExit of its own.
    """

    def __init__(
        self,
        coroutine: Handling,
        waits_for: object,
        run: Callable[..., Any] = operator.call,  # as Context.run
        error: BaseException | None = None,
    ) -> None:
        self.is_closed = False
        self._coroutine = coroutine
        self._waits_for = waits_for
        self._run = run
        self._error = error

    def __await__(self) -> Generator[object, object, object]:
        coroutine, run, waits_for = self._coroutine, self._run, self._waits_for
        try:
            if self._error is not None:
                waits_for = run(coroutine.throw, self._error)
            elif waits_for is NOT_BEGUN or waits_for is IS_DUE:
                waits_for = run(coroutine.send, None)
            while True:
                try:
                    value = yield waits_for
                except GeneratorExit:
                    self.is_closed = True
                    run(coroutine.close)
                    raise
                except BaseException as exc:  # noqa: BLE001  # whatever the task is told belongs to the coroutine
                    waits_for = run(coroutine.throw, exc)
                else:
                    waits_for = run(coroutine.send, value)
        except StopIteration as stop:
            return stop.value
        finally:
            self._error = None
