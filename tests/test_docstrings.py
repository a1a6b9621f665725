"""A docstring begins with what something is or does, not with a question."""

from __future__ import annotations

import ast
import re

import pytest
from tests.source_trees import source_nodes, source_texts

pytestmark = pytest.mark.no_cover

RIDDLE = re.compile(r"(What|Who|Whoever|Whom|Whose|Which|Whether|How|Where|When|Why|Whatever)\b")

VERBS = """
Abort Accept Acknowledge Acquire Add Advance Advertise Allow Announce Answer Append Apply
Approve Arm Ask Assign Attach Await Be
Begin Bind Book Bound Bring Build Cache Call Cancel Carry Change Charge Check Choose Clean Clear Close Collect
Combine Command Compare Compute Confirm Connect Consume Convert Copy Count Create Cut Decide Declare Decode Decrypt
Delete Deliver Derive Describe Detach Disable Disarm Discard Disconnect Dispatch Dispose Do Drain Draw Drop Emit Enable
Encode Encrypt End Ensure Enter Escape Estimate Evaluate Execute Exit Expand Expire Export Expose Extract Fail Feel
Fetch Mask Stream
Fill Filter Find Flatten Flush Fold Follow Forget Format Forward Free Gather Generate Get Give Go Group Guess Hand
Handle Hash Have Hide Hold Ignore Import Increment Insert Inspect Interpret Invoke Iterate Join Keep Launch Learn
Leave Let
Limit List Load Lock Log Look Make Map Mark Match Measure Merge Move Name Need Normalise Note Notify Obey Offer Open
Operate Order Override Pair Parse Pass Pause Perform Pick Plan Play Poll Pop Prefer Prepare Print Process Prune
Publish Push Put Queue Quote Raise Rank Reach Read Rebuild Receive Reconnect Record Recover Reduce Refresh Refuse
Register Reject Release Remember Remove Rename Render Renew Repeat Replace Reply Report Request Require Reserve Reset
Resist Revoke
Resolve Restart Restore Restrict Resume Retain Retry Return Reuse Revert Rewrite Rotate Round Route Run Save Scale
Schedule Search See Select Send Serialise Serve Set Share Shift Shorten Show Simplify Simulate Skip Sleep Sort Spell
Split Spread Stamp Start Step Stop Store Subscribe Sum Suppress Swap Sweep Switch Take Test Throttle Tilt Toggle Trace
Track Transform Translate Trigger Trim Truncate Turn Unlock Unpack Unregister Unsubscribe Unwrap Update Use Validate
Verify Visit Wait Wake Walk Warn Watch Widen Withdraw Work Wrap Write Yield
"""
"""Verbs that functions begin with. Add a further one here, if it is a verb and none of these says the same."""


def documented() -> list[tuple[str, str]]:
    """The place of each docstring, and its text."""
    return [
        (f"{path}:{getattr(node, 'lineno', 1)}", text)
        for path, node in source_nodes()
        if (text := ast.get_docstring(node))
    ]


def test_no_docstring_begins_with_a_question_word() -> None:
    found = documented()
    assert len(found) > 3000
    assert [place for place, text in found if RIDDLE.match(text)] == []


PRONOUN = re.compile(r"\b(who|whom|whose|whoever|what|whatever|nobody|somebody|anybody)\b", re.IGNORECASE)


def test_docstrings_and_comments_name_things_and_not_whatever_they_are() -> None:
    """At most two question words and indefinite pronouns in 1,000 words."""
    comments = [line.partition("# ")[2] for text in source_texts().values() for line in text.splitlines()]
    prose = [*(text for _, text in documented()), *comments]
    words = sum(len(text.split()) for text in prose)
    assert 1000 * sum(len(PRONOUN.findall(text)) for text in prose) / words <= 2


def test_the_first_paragraph_of_every_docstring_is_a_sentence_or_ends_in_a_colon() -> None:
    assert [place for place, text in documented() if text.partition("\n\n")[0][-1] not in ".:?!"] == []


def is_attribute(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """A property or a fixture is read as the value that it gives, and may begin with a noun."""
    names = {ast.unparse(one).partition("(")[0].rpartition(".")[2] for one in function.decorator_list}
    return bool(names & {"property", "cached_property", "fixture"})


def first_words() -> list[tuple[str, str]]:
    """The place of each docstring of a function, and its first word."""
    return [
        (f"{path}:{node.lineno} {node.name}", text.split()[0].rstrip(".,:;"))
        for path, node in source_nodes()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not is_attribute(node)
        if not node.name.startswith("test_") and (text := ast.get_docstring(node))
    ]


def test_the_docstring_of_a_function_begins_with_a_verb() -> None:
    found = first_words()
    assert len(found) > 2000
    verbs = set(VERBS.split())
    assert [f"{place}: {word}" for place, word in found if word not in verbs] == []


def entries(text: str, section: str) -> list[str]:
    """The names that a section of a docstring explains."""
    lines = text.partition(f"\n{section}:\n")[2].partition("\n\n")[0].splitlines()
    found = [re.match(r"    \*{0,2}(\w+(?:, \w+)*): ", line) for line in lines]
    return [name for match in found if match for name in match[1].split(", ")]


def arguments(function: ast.FunctionDef | ast.AsyncFunctionDef) -> set[str]:
    every = function.args
    more = [one for one in (every.vararg, every.kwarg) if one is not None]
    return {one.arg for one in (*every.posonlyargs, *every.args, *every.kwonlyargs, *more)}


def members(class_: ast.ClassDef) -> set[str]:
    """The names that a class defines or sets."""
    found = {node.attr for node in ast.walk(class_) if isinstance(node, ast.Attribute)}
    for node in class_.body:
        match node:
            case ast.AnnAssign(target=ast.Name(id=name)) | ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                found.add(name)
            case ast.Assign(targets=targets):
                found |= {target.id for target in targets if isinstance(target, ast.Name)}
            case _:
                pass
    return found


def unknown_entries(node: ast.AST) -> list[str]:
    """The names in the docstring of a class or function that it does not have."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return sorted({*entries(ast.get_docstring(node) or "", "Args")} - arguments(node))
    if not isinstance(node, ast.ClassDef):
        return []
    text = ast.get_docstring(node) or ""
    attributes, taken = {*entries(text, "Attributes")}, {*entries(text, "Args")}
    if not attributes and not taken:
        return []
    known = members(node)
    inits = [one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"]
    return sorted((attributes - known) | (taken - (arguments(inits[0]) if inits else known)))


def test_the_arguments_and_attributes_that_a_docstring_explains_are_there() -> None:
    found = [
        (path, getattr(node, "name", ""), names) for path, node in source_nodes() if (names := unknown_entries(node))
    ]
    assert found == []


def test_an_entry_that_nothing_bears_is_found() -> None:
    text = "A lamp.\n\n    Attributes:\n        level: In percent.\n        word: No.\n    "
    code = f'class Lamp:\n    """{text}"""\n    level = 0\n'
    assert unknown_entries(ast.parse(code).body[0]) == ["word"]
