"""``homebot --print-completion``: the script with which a shell completes commands, options, choices and files."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from typing import Final

__all__ = ["SHELLS", "PrintCompletion"]

SHELLS: Final = ("bash", "zsh")


class PrintCompletion(argparse.Action):
    """Prints the completion script of the whole parser for a shell, and ends the program.

    Args:
        option_strings: As argparse makes actions.
        dest: As above.
        choices: The shells.
        whole_parser: Returns the parser with the arguments of all commands.
        help: As above.
    """

    def __init__(
        self,
        option_strings: Sequence[str],
        dest: str,
        *,
        choices: Sequence[str],
        whole_parser: Callable[[], argparse.ArgumentParser],
        help: str,  # noqa: A002 - argparse's spelling
    ) -> None:
        super().__init__(option_strings, dest, choices=choices, help=help)
        self._whole_parser = whole_parser

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,  # noqa: ARG002 - argparse's signature
        values: str | Sequence[object] | None,
        option_string: str | None = None,  # noqa: ARG002 - as above
    ) -> None:
        """Print it."""
        import shtab  # noqa: PLC0415 - used here alone

        whole = self._whole_parser()
        for action in _actions(whole):
            if action.metavar in {"FILE", "DIR"}:
                kind = shtab.FILE if action.metavar == "FILE" else shtab.DIRECTORY
                action.complete = kind  # type: ignore[attr-defined]  # where shtab looks
        print(shtab.complete(whole, str(values)))
        parser.exit()


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:  # noqa: SLF001 - argparse has no other way, and shtab goes it too
        yield action
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001 - as above
            for command in action.choices.values():
                yield from _actions(command)
