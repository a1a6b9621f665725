"""The context in which one automation is read. Pure."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeVar

from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Entities
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.support.located import Located

T = TypeVar("T")


@dataclass
class Automation:
    """An automation, or its part for the triggers of one id.

    Attributes:
        trigger: The id of these triggers; None for all of the automation.
        problems: All that is not carried over.
        starts: The triggers of states: their entities and their states.
    """

    entities: Entities
    problems: list[NotCarriedError]
    trigger: str | None = None
    starts: list[tuple[frozenset[str], frozenset[str]]] = field(default_factory=list)

    def each(self, nodes: Sequence[Located], what: str, read: Callable[[UnreadFields], T]) -> list[T]:
        """Return what *read* returns for each of *nodes* that is switched on and carried over."""
        results: list[T] = []
        for node in nodes:
            with self.in_line(node.line):
                fields = UnreadFields(node, what)
                if fields.flag("enabled", default=True):
                    results.append(read(fields))
                    fields.end()
        return results

    @contextmanager
    def in_line(self, line: int) -> Iterator[None]:
        """Add what is refused to the problems, by default with *line*."""
        try:
            yield
        except UsageError as exc:
            own = exc.line if isinstance(exc, NotCarriedError) else 0
            self.problems.append(NotCarriedError(str(exc), own or line))
