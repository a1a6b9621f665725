"""Remarks and errors of commands: lines for people, under ``--json`` an object each; on the standard error."""

import json
import sys


def remark(text: str, *, as_json: bool, key: str = "note") -> None:
    """Print *text* for people after the name of the program; *as_json*, as a JSON object with this *key*."""
    print(json.dumps({key: text}) if as_json else f"homebot: {text}", file=sys.stderr)


def print_error(text: str, *, as_json: bool) -> None:
    """Print why a command failed, as :func:`remark` does, with the key ``error``."""
    remark(text, as_json=as_json, key="error")
