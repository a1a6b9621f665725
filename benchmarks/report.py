"""One table for each benchmark: ours, the peer, their ratio, and whether the aim is met."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Literal

from rounds import Samples, median

__all__ = [
    "Aim",
    "Comparison",
    "MissingPeerError",
    "Report",
    "compare",
    "megabytes",
    "milliseconds",
    "per_second",
    "print_report",
    "seconds",
    "verdict",
]


SHORT = "FALLS SHORT"


class MissingPeerError(Exception):
    """Nothing can be measured here, as a program or library is missing."""


def verdict(is_met: bool) -> str:
    """Return the words for an aim; a report with ``FALLS SHORT`` ends the program with an error."""
    return "met" if is_met else SHORT


@dataclass(frozen=True, slots=True)
class Aim:
    """What a ratio shall be.

    Attributes:
        kind: ``at least`` where more is better, ``at most`` where less is.
        ratio: Ours divided by the peer's.
    """

    kind: Literal["at least", "at most"]
    ratio: float

    def verdict(self, ratio: float) -> str:
        met = ratio >= self.ratio if self.kind == "at least" else ratio <= self.ratio
        return f"{'>=' if self.kind == 'at least' else '<='} {self.ratio:g}: {verdict(met)}"


@dataclass(frozen=True, slots=True)
class Comparison:
    """One line of a table: two contenders whose rounds were measured in turn.

    Attributes:
        ours: Figures of homebot, one a round.
        peer: Figures of the peer in the same rounds.
        show: Puts one figure into words.
    """

    case: str
    ours_name: str
    peer_name: str
    ours: Sequence[float]
    peer: Sequence[float]
    show: Callable[[float], str]
    aim: Aim | None = None

    def row(self) -> tuple[str, ...]:
        ratios = sorted(ours / peer for ours, peer in zip(self.ours, self.peer, strict=True))
        ratio = median(ratios)
        return (
            self.case,
            self.ours_name,
            self.show(median(list(self.ours))),
            self.peer_name,
            self.show(median(list(self.peer))),
            f"{ratio:.3g} x",
            f"{ratios[0]:.3g} - {ratios[-1]:.3g}",
            self.aim.verdict(ratio) if self.aim else "",
        )


HEADINGS = ("case", "homebot", "median", "peer", "median", "ratio", "min - max", "aim")


@dataclass(frozen=True, slots=True)
class Report:
    """What one benchmark found.

    Attributes:
        title: What was measured.
        comparisons: The table.
        notes: Lines below it: losses, what was skipped.
        table: A table of another form, its headings first; for what has no peer.
        missing: What is missing for a part of it, which was not measured.
    """

    title: str
    comparisons: Sequence[Comparison]
    notes: Sequence[str] = ()
    table: Sequence[tuple[str, ...]] = ()
    missing: Sequence[str] = ()

    @property
    def falls_short(self) -> bool:
        """Whether an aim is missed."""
        cells = chain(*(one.row() for one in self.comparisons), *self.table, self.notes)
        return any(SHORT in cell for cell in cells)


def compare(
    case: str,
    samples: Samples,
    pairs: Iterable[tuple[str, str, Aim | None]],
    show: Callable[[float], str],
) -> list[Comparison]:
    """Return a line for each pair of names (ours, peer) that was measured."""
    return [
        Comparison(case, ours, peer, samples[ours], samples[peer], show, aim)
        for ours, peer, aim in pairs
        if ours in samples and peer in samples
    ]


def print_report(report: Report) -> None:
    print(f"\n## {report.title}\n")
    if report.comparisons:
        _print_table([HEADINGS, *(comparison.row() for comparison in report.comparisons)])
    if report.table:
        _print_table(report.table)
    for note in (*report.notes, *(f"NOT MEASURED: {one}." for one in report.missing)):
        print(f"\n{note}")


def per_second(figure: float) -> str:
    return (
        f"{figure / 1e6:.2f} M/s" if figure >= 1e6 else f"{figure / 1e3:.1f} k/s" if figure >= 1e3 else f"{figure:g}/s"
    )


def seconds(figure: float) -> str:
    return f"{figure * 1e3:.0f} ms" if figure >= 0.01 else f"{figure * 1e6:.0f} µs"


def milliseconds(figure: float) -> str:
    return f"{figure * 1e3:.2f} ms"


def megabytes(figure: float) -> str:
    return f"{figure / 2**20:.1f} MiB"


def _print_table(rows: Sequence[tuple[str, ...]]) -> None:
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    for number, row in enumerate(rows):
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |")
        if number == 0:
            print("|" + "|".join("-" * (width + 2) for width in widths) + "|")
