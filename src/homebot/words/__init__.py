"""The only reader of what people write: tokens, times, names, and small grammars over them. Pure.

A query becomes the terms of :mod:`homebot.devices.query`; a command, the settings of a part.
"""
