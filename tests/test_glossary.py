"""The glossary names what there is, and the names of classes are made of its words."""

from __future__ import annotations

import ast
import re
from collections import Counter

import pytest
from tests.source_trees import SOURCE, source_nodes, source_trees

pytestmark = pytest.mark.no_cover

GLOSSARY = (SOURCE.parent.parent / "docs" / "glossary.md").read_text()

FAMILIES = (
    "bridges/rosapi/",
    "bridges/rosbridge/",
    "bridges/thing_directory/",
    "conventions/homeassistant/",
    "conventions/homie/",
    "conventions/jinja/",
    "conventions/shelly/",
    "conventions/tasmota/",
    "conventions/zigbee2mqtt/",
    "devices/handles/",
    "devices/query/",
    "house/",
    "messages/",
    "mqtt/packets/",
    "wot/",
)
"""Folders whose classes have names of somebody else's: of a maker, of a standard, of things in a house."""

PLAIN = """
account ack base choice memory paho version
ahead alive applicant authentication backoff blocking budget byte cached candidate clean
completion connect console context conversion core count counter deadline deferred delayed descriptor dial
dict dropped duplicate dutie entity excess expiring fact fake feed find flight forget frame grant group half health
held history host hosted housekeeping inbound inbox info intake journal keeper keyed lazy life limit
liveliness liveness loaded login loss manual mark merger open option outbound output parser phase place
planned policy pool problem production publish publishing pulse quantity queued reach receipt received receiver
recipient recorded recorder regrouped reliability renderer replay reporting reserved reserving result schema search
secret selector shared sign slice sliced slot spare starved stat tap target test thread throttle tl transport trimmer
unread unsaved unsent user view violation waiting watch watchdog watched window
"""
"""Words that mean in a name what they mean in English, or in every program; any other belongs into the glossary."""


def classes() -> dict[str, str]:
    """Every public class of src, and the folder or file that it is in."""
    return {
        node.name: path
        for path, tree in source_trees().items()
        for node in tree.body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    }


def aliases() -> set[str]:
    return {
        node.target.id
        for tree in source_trees().values()
        for node in tree.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }


def words(text: str) -> set[str]:
    """The words of *text*, those that CamelCase joins taken apart, in the singular."""
    found = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", text)
    return {re.sub(r"(?<=[^s])s$", "", word.lower()) for word in found}


def test_every_class_it_names_exists() -> None:
    named = set(re.findall(r"`([A-Z][a-z]\w*)`", GLOSSARY))
    assert len(named) > 80
    assert named - set(classes()) - aliases() == set()


def test_no_term_stands_twice() -> None:
    terms = [
        row.split(",")[0].strip() for row in re.findall(r"^\| (?!Term|Names)([^|-][^|]*) \|", GLOSSARY, re.MULTILINE)
    ]
    assert len(terms) == len(set(terms)) > 80


def test_the_names_of_classes_are_made_of_its_words_or_plain_ones() -> None:
    known = words(GLOSSARY) | words(PLAIN)
    unknown = {
        name: sorted(words(name) - known)
        for name, file in classes().items()
        if not file.startswith(FAMILIES) and not name.endswith("Error") and words(name) - known
    }
    assert unknown == {}


TWICE = {"Clock", "Parameter", "Path", "Pose", "Range"}
"""Messages of ROS, whose names are ROS's, and what has that name here, such as a parameter of a node."""


def test_no_two_classes_have_one_name() -> None:
    names = Counter(node.name for _, node in source_nodes() if isinstance(node, ast.ClassDef))
    assert {name for name, number in names.items() if number > 1} == TWICE
