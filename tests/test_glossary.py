"""The glossary names existing classes, each term once."""

import ast
import re
from collections import Counter

import pytest
from tests.source_trees import SOURCE, source_nodes, source_trees

pytestmark = pytest.mark.no_cover

GLOSSARY = (SOURCE.parent.parent / "docs" / "glossary.md").read_text()


def classes() -> set[str]:
    """Return the names of the public classes of src."""
    return {
        node.name
        for tree in source_trees().values()
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


def test_every_class_it_names_exists() -> None:
    named = set(re.findall(r"`([A-Z][a-z]\w*)`", GLOSSARY))
    assert len(named) > 50
    assert named - classes() - aliases() == set()


def test_no_term_stands_twice() -> None:
    terms = [row.split(",")[0].strip() for row in re.findall(r"^\| (?!Term)([^|-][^|]*) \|", GLOSSARY, re.MULTILINE)]
    assert len(terms) == len(set(terms)) > 50


TWICE = {"Parameter"}
"""A message of ROS, whose name is ROS's, and the parameter of a node."""


def test_no_two_classes_have_one_name() -> None:
    names = Counter(node.name for _, node in source_nodes() if isinstance(node, ast.ClassDef))
    assert {name for name, number in names.items() if number > 1} == TWICE
