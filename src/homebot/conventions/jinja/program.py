"""A template that was read: what it does, step by step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import final

from homebot.conventions.jinja.errors import TemplateError
from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.statements import Execute

__all__ = ["Program"]


@final
class Program:
    """A template that was read.

    Args:
        body: What it does.
        names: The names whose meaning it asks for.
        weight: The work of going through all of it once, in steps.
    """

    __slots__ = ("_body", "_weight", "names")

    def __init__(self, body: Sequence[Execute], names: frozenset[str], weight: int) -> None:
        self._body = tuple(body)
        self._weight = weight
        self.names = names

    def render(self, variables: Mapping[str, object], now: datetime | None) -> str:
        """Return the text that it writes; see :meth:`Template.render`."""
        run = Run(variables, now)
        try:
            run.spend(self._weight)
            for statement in self._body:
                statement(run)
        except RecursionError:
            raise TemplateError("a value is nested too deeply") from None
        except (TypeError, ArithmeticError) as error:
            raise TemplateError(f"the values do not fit the template: {str(error)[:_MOST_SHOWN]}") from error
        except (ValueError, LookupError, AttributeError) as error:
            # Their messages may show a value, which may be the code of a lock.
            raise TemplateError(f"the values do not fit the template: {type(error).__name__}") from None
        return run.written()


_MOST_SHOWN = 80
