"""Argument parser that suggests similar options and commands for unknown ones, and shell completion."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Final, NoReturn

from homebot.support.names import similar_to

SHELLS: Final = ("bash", "zsh", "fish")

SYNONYMS: Final = {
    "list": "devices",
    "ls": "devices",
    "status": "doctor",
    "health": "doctor",
    "check": "doctor",
    "log": "journal",
    "logs": "journal",
    "set": "do",
    "turn": "do",
    "switch": "do",
    "explain": "why",
    "start": "run",
    "room": "place",
    "delete": "forget",
    "remove": "forget",
    "rename": "alias",
    "search": "find",
    "info": "show",
}
"""Words of other tools for commands of homebot."""

_COMMANDS: Final = (
    *("on", "off", "open", "close", "stop", "lock", "unlock", "arm", "disarm"),
    *("play", "pause", "mute", "unmute", "press"),
)
"""Words that devices take, for completion."""

_WRONG_COMMAND_LINE = 2
_CUTOFF = 0.6


class CommandParser(argparse.ArgumentParser):
    """Parser of ``homebot`` or one of its commands; prints its help if a required command is missing."""

    _given: Sequence[str] = ()

    def parse_known_args(  # type: ignore[override]  # no other class of namespace is passed
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse *args*, all of which must be known; the command with an unknown one reports it.

        Raises:
            SystemExit: *args* are wrong (code 2), or request help (code 0).
        """
        self._given = sys.argv[1:] if args is None else args
        if not self._given and self._commands() is not None:
            self.print_help()
            self.exit(_WRONG_COMMAND_LINE)
        parsed, unknown = super().parse_known_args(self._given, namespace)
        if unknown:
            option = next((argument for argument in unknown if argument.startswith("-")), "")
            stray = f"unexpected argument {unknown[0]!r}; {self._hint}"
            self._refuse(self._unknown_option(option) if option else stray)
        return parsed, unknown

    def error(self, message: str) -> NoReturn:
        """End the program with *message*, or with an unknown option that may be its cause."""
        if option := next(self._unknown_options(), ""):
            self._refuse(self._unknown_option(option))
        if "--json" in self._given:
            self._refuse(message)
        super().error(message)

    def _check_value(self, action: argparse.Action, value: str) -> None:
        commands = self._commands()
        if commands is not None and action is commands and value not in commands.choices:
            words = {word: command for word, command in SYNONYMS.items() if command in commands.choices}
            self._refuse(f"no command {value!r}; {self._meant(value, commands.choices, words=words)}")
        super()._check_value(action, value)

    @property
    def _hint(self) -> str:
        return f"see `{self.prog} --help`"

    def _commands(self) -> argparse._SubParsersAction[argparse.ArgumentParser] | None:
        kind = argparse._SubParsersAction  # noqa: SLF001 - argparse has no other way
        return next((action for action in self._actions if isinstance(action, kind)), None)

    def _unknown_options(self) -> Iterator[str]:
        """Yield unknown long options that were given to this command rather than a subcommand."""
        commands = self._commands()
        for argument in self._given:
            if argument == "--" or (commands is not None and argument in commands.choices):
                return
            name = argument.partition("=")[0]
            is_known = any(option.startswith(name) for option in self._option_string_actions)
            if name.startswith("--") and " " not in name and not is_known:
                yield name

    def _unknown_option(self, option: str) -> str:
        name = option.partition("=")[0]
        known = [action[2:] for action in self._option_string_actions if action.startswith("--")]
        return f"unknown option {name}; {self._meant(name.lstrip('-'), known, '--')}"

    def _meant(
        self, name: str, known: Iterable[str], prefix: str = "", words: Mapping[str, str] = MappingProxyType({})
    ) -> str:
        """Return the most similar of the *known* names and *words*, or a hint to the help."""
        similar = similar_to(name, (*known, *words), _CUTOFF)
        return f"did you mean {prefix}{words.get(similar[0], similar[0])}?" if similar else self._hint

    def _refuse(self, problem: str) -> NoReturn:
        is_json = "--json" in self._given
        self.exit(_WRONG_COMMAND_LINE, f"{json.dumps({'error': problem}) if is_json else f'{self.prog}: {problem}'}\n")


class PrintCompletion(argparse.Action):
    """Prints the completion script of the whole parser for a shell, and ends the program.

    Args:
        whole_parser: Returns the parser with the arguments of all commands.
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

        from homebot.cli.device_completion import DEVICE_NAMES  # noqa: PLC0415 - as above

        kinds = {"FILE": shtab.FILE, "DIR": shtab.DIRECTORY, "DEVICE": DEVICE_NAMES, "QUERY": DEVICE_NAMES}
        whole = self._whole_parser()
        for action in _actions(whole):
            if action.metavar in kinds:
                action.complete = kinds[str(action.metavar)]  # type: ignore[attr-defined]  # where shtab looks
            elif action.metavar == "COMMAND" and not action.choices:
                action.choices = _COMMANDS
        print(shtab.complete(whole, str(values)))
        parser.exit()


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:  # noqa: SLF001 - argparse has no other way, and shtab goes it too
        yield action
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001 - as above
            for command in action.choices.values():
                yield from _actions(command)
