"""Reads templates with Jinja's own parser, and lets through a listed part of its language. Only here is Jinja known.

Source: Jinja 3.1 documentation, The Abstract Syntax Tree. Of Jinja nothing but its lexer and parser is used: templates
are executed by :mod:`expressions` and :mod:`statements`.
"""

from __future__ import annotations

import operator
import warnings
from collections.abc import Callable, Iterable
from itertools import islice
from typing import Final, TypeAlias, final

import jinja2
from jinja2 import nodes

from homebot.conventions.jinja import expressions, statements
from homebot.conventions.jinja.expressions import Evaluate
from homebot.conventions.jinja.functions import CONSTANTS, FILTERS, FUNCTIONS, HOME_ASSISTANT
from homebot.conventions.jinja.limits import MAX_DEPTH, MAX_FOR_DEPTH, MAX_TOKENS, TemplateError
from homebot.conventions.jinja.methods import METHODS
from homebot.conventions.jinja.statements import Assign, Execute, Program
from homebot.conventions.jinja.tests import CHECKS
from homebot.conventions.jinja.values import UNDEFINED

__all__ = ["parse"]


def parse(source: str) -> Program:
    """Return the program of the template *source*.

    Raises:
        TemplateError: It is no template, or uses an unsupported feature; the problem names it, in a few
            words that follow "the template".
    """
    _check_brackets(source)
    tree = _tree(source)
    reader = _SyntaxReader()
    try:
        body = reader.statements(tree.body)
    except RecursionError:
        raise TemplateError("is nested too deeply") from None
    missing = (reader.referenced - reader.assigned) & HOME_ASSISTANT
    if missing:
        raise TemplateError(f"uses `{min(missing)}`, which only Home Assistant has")
    return Program(body, frozenset(reader.referenced), reader.weight)


@final
class _SyntaxReader:
    """Goes through Jinja's tree once; *weight* counts its nodes."""

    def __init__(self) -> None:
        self.referenced: set[str] = set()
        self.assigned: set[str] = set()
        self.weight = 0
        self._depth = 0
        self._loops = 0
        self._in_loop = False

    def statements(self, body: Iterable[nodes.Node]) -> tuple[Execute, ...]:
        return tuple([self._statement(node) for node in body])

    def _statement(self, node: nodes.Node) -> Execute:
        read = _STATEMENTS.get(type(node))
        if read is None:
            raise TemplateError(f"uses {_described(node)}, which is not supported")
        self._enter()
        statement = read(self, node)
        self._depth -= 1
        return statement

    def expression(self, node: nodes.Node) -> Evaluate:
        read = _EXPRESSIONS.get(type(node))
        if read is None:
            raise TemplateError(f"uses {_described(node)}, which is not supported")
        self._enter()
        expression = read(self, node)
        self._depth -= 1
        return expression

    def _enter(self) -> None:
        self.weight += 1
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise TemplateError("is nested too deeply")

    def _expressions(self, many: Iterable[nodes.Node]) -> list[Evaluate]:
        return [self.expression(node) for node in many]

    def _target(self, node: nodes.Node) -> Assign:
        self.weight += 1
        if isinstance(node, nodes.Name):
            self.assigned.add(node.name)
            return statements.to_name(node.name)
        if isinstance(node, nodes.NSRef):
            return statements.to_attribute(node.name, node.attr)
        if isinstance(node, nodes.Tuple):
            return statements.to_several([self._target(one) for one in node.items])
        raise TemplateError(f"assigns to {_described(node)}, which is not supported")

    def output(self, node: nodes.Output) -> Execute:
        return statements.output(self._expressions(node.nodes))

    def data(self, node: nodes.TemplateData) -> Evaluate:
        return expressions.constant(node.data)

    def if_(self, node: nodes.If) -> Execute:
        cases = [(self.expression(one.test), self.statements(one.body)) for one in (node, *node.elif_)]
        return statements.choice(cases, self.statements(node.else_))

    def for_(self, node: nodes.For) -> Execute:
        if node.recursive:
            raise TemplateError("uses a recursive loop, which is not supported")
        self._loops += 1
        if self._loops > MAX_FOR_DEPTH:
            raise TemplateError(f"has more than {MAX_FOR_DEPTH} nested loops")
        values = self.expression(node.iter)
        before = self.weight
        target = self._target(node.target)
        test = None if node.test is None else self.expression(node.test)
        around, self._in_loop = self._in_loop, True
        body = self.statements(node.body)
        self._in_loop = around
        weight = self.weight - before
        self._loops -= 1
        return statements.loop(target, values, test, body, self.statements(node.else_), weight)

    def assign(self, node: nodes.Assign) -> Execute:
        return statements.assignment(self._target(node.target), self.expression(node.node))

    def assign_block(self, node: nodes.AssignBlock) -> Execute:
        if node.filter is not None:
            raise TemplateError("uses a filter on a block, which is not supported")
        around, self._in_loop = self._in_loop, False
        body = self.statements(node.body)
        self._in_loop = around
        return statements.block_assignment(self._target(node.target), body)

    def break_(self, node: nodes.Node) -> Execute:
        self._must_be_in_loop(node)
        return statements.break_loop

    def continue_(self, node: nodes.Node) -> Execute:
        self._must_be_in_loop(node)
        return statements.continue_loop

    def name(self, node: nodes.Name) -> Evaluate:
        self.referenced.add(node.name)
        return expressions.name(node.name, CONSTANTS.get(node.name, UNDEFINED))

    def constant(self, node: nodes.Const) -> Evaluate:
        value: object = node.value
        if isinstance(value, int) and value.bit_length() > _LARGEST_LITERAL:
            raise TemplateError("has a number that is too large")
        return expressions.constant(value)

    def list_(self, node: nodes.List) -> Evaluate:
        return expressions.listing(self._expressions(node.items), list)

    def tuple_(self, node: nodes.Tuple) -> Evaluate:
        return expressions.listing(self._expressions(node.items), tuple)

    def mapping(self, node: nodes.Dict) -> Evaluate:
        return expressions.mapping([(self.expression(one.key), self.expression(one.value)) for one in node.items])

    def attribute(self, node: nodes.Getattr) -> Evaluate:
        return expressions.lookup(self.expression(node.node), expressions.constant(node.attr))

    def item(self, node: nodes.Getitem) -> Evaluate:
        value = self.expression(node.node)
        if isinstance(node.arg, nodes.Slice):
            bounds = (node.arg.start, node.arg.stop, node.arg.step)
            return expressions.part(
                value, [expressions.constant(None) if one is None else self.expression(one) for one in bounds]
            )
        return expressions.lookup(value, self.expression(node.arg))

    def condition(self, node: nodes.CondExpr) -> Evaluate:
        no = expressions.constant(UNDEFINED) if node.expr2 is None else self.expression(node.expr2)
        return expressions.condition(self.expression(node.test), self.expression(node.expr1), no)

    def binary(self, node: nodes.BinExpr) -> Evaluate:
        return expressions.binary(type(node).__name__, self.expression(node.left), self.expression(node.right))

    def and_(self, node: nodes.And) -> Evaluate:
        return expressions.conjunction(self.expression(node.left), self.expression(node.right))

    def or_(self, node: nodes.Or) -> Evaluate:
        return expressions.disjunction(self.expression(node.left), self.expression(node.right))

    def not_(self, node: nodes.Not) -> Evaluate:
        return expressions.negation(self.expression(node.node))

    def negative(self, node: nodes.Neg) -> Evaluate:
        return expressions.sign(operator.neg, self.expression(node.node))

    def positive(self, node: nodes.Pos) -> Evaluate:
        return expressions.sign(operator.pos, self.expression(node.node))

    def compare(self, node: nodes.Compare) -> Evaluate:
        others = [(one.op, self.expression(one.expr)) for one in node.ops]
        return expressions.comparison(self.expression(node.expr), others)

    def concatenation(self, node: nodes.Concat) -> Evaluate:
        return expressions.concatenation(self._expressions(node.nodes))

    def filter_(self, node: nodes.Filter) -> Evaluate:
        if node.node is None or node.name not in FILTERS:
            raise TemplateError(f"uses the filter `{node.name[:_MOST_SHOWN]}`, which is not supported")
        return self._call(FILTERS[node.name], [node.node, *node.args], node)

    def check(self, node: nodes.Test) -> Evaluate:
        if node.name not in CHECKS:
            raise TemplateError(f"uses the test `{node.name[:_MOST_SHOWN]}`, which is not supported")
        return self._call(CHECKS[node.name], [node.node, *node.args], node)

    def called(self, node: nodes.Call) -> Evaluate:
        called = node.node
        if isinstance(called, nodes.Name):
            if called.name in HOME_ASSISTANT:
                raise TemplateError(f"uses `{called.name}()`, which only Home Assistant has")
            if called.name not in FUNCTIONS:
                raise TemplateError(f"uses the function `{called.name[:_MOST_SHOWN]}()`, which is not supported")
            return self._call(FUNCTIONS[called.name], node.args, node)
        if not isinstance(called, nodes.Getattr):
            raise TemplateError("calls something that is not a function")
        if not any(called.attr in methods for methods in METHODS.values()):
            raise TemplateError(f"uses the method `{called.attr[:_MOST_SHOWN]}()`, which is not supported")
        owner = self.expression(called.node)
        self._refuse_unpacking(node)
        return expressions.call_method(owner, called.attr, self._expressions(node.args), self._named(node))

    def _call(
        self,
        function: expressions.Function,
        arguments: Iterable[nodes.Node],
        node: nodes.Call | nodes.Filter | nodes.Test,
    ) -> Evaluate:
        self._refuse_unpacking(node)
        return expressions.call(function, self._expressions(arguments), self._named(node))

    def _named(self, node: nodes.Call | nodes.Filter | nodes.Test) -> list[tuple[str, Evaluate]]:
        return [(one.key, self.expression(one.value)) for one in node.kwargs if isinstance(one, nodes.Keyword)]

    def _must_be_in_loop(self, node: nodes.Node) -> None:
        if not self._in_loop:
            raise TemplateError(f"uses {_described(node)} outside a loop")

    def _refuse_unpacking(self, node: nodes.Call | nodes.Filter | nodes.Test) -> None:
        if node.dyn_args is not None or node.dyn_kwargs is not None:
            raise TemplateError("calls with `*` or `**`, which is not supported")


_ENVIRONMENT: Final = jinja2.Environment(extensions=["jinja2.ext.loopcontrols"])  # noqa: S701  # only parses
_MOST_SHOWN = 60
_LARGEST_LITERAL = 64

_ReadExpression: TypeAlias = Callable[..., Evaluate]
_ReadStatement: TypeAlias = Callable[..., Execute]

_EXPRESSIONS: Final[dict[type[nodes.Node], _ReadExpression]] = {
    nodes.Add: _SyntaxReader.binary,
    nodes.And: _SyntaxReader.and_,
    nodes.Call: _SyntaxReader.called,
    nodes.Compare: _SyntaxReader.compare,
    nodes.Concat: _SyntaxReader.concatenation,
    nodes.CondExpr: _SyntaxReader.condition,
    nodes.Const: _SyntaxReader.constant,
    nodes.Dict: _SyntaxReader.mapping,
    nodes.Div: _SyntaxReader.binary,
    nodes.Filter: _SyntaxReader.filter_,
    nodes.FloorDiv: _SyntaxReader.binary,
    nodes.Getattr: _SyntaxReader.attribute,
    nodes.Getitem: _SyntaxReader.item,
    nodes.List: _SyntaxReader.list_,
    nodes.Mod: _SyntaxReader.binary,
    nodes.Mul: _SyntaxReader.binary,
    nodes.Name: _SyntaxReader.name,
    nodes.Neg: _SyntaxReader.negative,
    nodes.Not: _SyntaxReader.not_,
    nodes.Or: _SyntaxReader.or_,
    nodes.Pos: _SyntaxReader.positive,
    nodes.Pow: _SyntaxReader.binary,
    nodes.Sub: _SyntaxReader.binary,
    nodes.TemplateData: _SyntaxReader.data,
    nodes.Test: _SyntaxReader.check,
    nodes.Tuple: _SyntaxReader.tuple_,
}

_STATEMENTS: Final[dict[type[nodes.Node], _ReadStatement]] = {
    nodes.Assign: _SyntaxReader.assign,
    nodes.AssignBlock: _SyntaxReader.assign_block,
    nodes.Break: _SyntaxReader.break_,
    nodes.Continue: _SyntaxReader.continue_,
    nodes.For: _SyntaxReader.for_,
    nodes.If: _SyntaxReader.if_,
    nodes.Output: _SyntaxReader.output,
}


def _tree(source: str) -> nodes.Template:
    try:
        # Python warns of texts such as '\d', which are common in regular expressions.
        with warnings.catch_warnings(action="ignore"):
            if len(source) > MAX_TOKENS and any(True for _ in islice(_ENVIRONMENT.lex(source), MAX_TOKENS, None)):
                raise TemplateError(f"has more than {MAX_TOKENS} tokens")
            return _ENVIRONMENT.parse(source)
    except jinja2.TemplateSyntaxError as error:
        raise TemplateError(f"is not a valid template: {(error.message or '')[:_MOST_SHOWN]}") from error
    except RecursionError:
        raise TemplateError("is nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise TemplateError("has a number or text that cannot be read") from error


def _check_brackets(source: str) -> None:
    depth = 0
    for character in source:
        if character in "([{":
            depth += 1
            if depth > MAX_DEPTH:
                raise TemplateError("is nested too deeply")
        elif character in ")]}":
            depth = max(0, depth - 1)


def _described(node: nodes.Node) -> str:
    return f"`{type(node).__name__.lower()}`"
