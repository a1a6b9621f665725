"""Timelines of parts: commands and reports as facts, and the questions that control asks about them. Pure."""
