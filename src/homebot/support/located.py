"""Values of files of YAML with their lines. Pure."""

from typing import NamedTuple


class Located(NamedTuple):
    """A value of a file of YAML.

    Attributes:
        value: A dict or list of located values, or a plain one.
        tag: Its own tag, such as ``!secret``; empty for none.
    """

    value: object
    line: int
    tag: str = ""
