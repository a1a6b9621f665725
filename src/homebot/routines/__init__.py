"""Routines: rules as data, in the words of ``homebot find`` and ``homebot do``.

A routine is an app without a program: its triggers, conditions and steps are texts, all of which are checked
when they are read. It is listed, reloaded and explained as an app, and its commands carry its name.
"""
