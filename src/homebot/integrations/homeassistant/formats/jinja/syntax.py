"""Compiler of templates: a listed part of Jinja's language as bounded functions.

A function, a method and an operator count the size of their values before, if it decides their cost, and the size of
their result after.

Source: Jinja 3.1 documentation, The Abstract Syntax Tree.
"""

import operator
import warnings
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Final, TypeAlias, final

import jinja2

from homebot.integrations.homeassistant.formats.jinja.evaluation import Evaluate, Program, Run, path_program
from homebot.integrations.homeassistant.formats.jinja.functions import FILTERS, FUNCTIONS, HOME_ASSISTANT
from homebot.integrations.homeassistant.formats.jinja.lists import CHECKS, slice_of, values_of
from homebot.integrations.homeassistant.formats.jinja.loop import Assign, BreakLoop, ContinueLoop, Loop
from homebot.integrations.homeassistant.formats.jinja.numbers import BINARY, CONSTANTS, ORDER
from homebot.integrations.homeassistant.formats.jinja.texts import METHODS, method_of
from homebot.integrations.homeassistant.formats.jinja.values import (
    MAX_DEPTH,
    MAX_FOR_DEPTH,
    MAX_TOKENS,
    UNDEFINED,
    Namespace,
    TemplateError,
    Undefined,
    item,
    text,
)

nodes = jinja2.nodes
"""The nodes of its trees."""

_ENVIRONMENT: Final = jinja2.Environment(extensions=["jinja2.ext.loopcontrols"])  # noqa: S701  # only parses


def tree_of(source: str) -> nodes.Template:
    """Return the tree of the template *source*.

    Raises:
        TemplateError: It is none, or too large; words that follow "the template".
    """
    if source.count("(") + source.count("[") + source.count("{") > MAX_DEPTH:
        depth = 0
        for character in source:
            if character in "([{":
                depth += 1
                if depth > MAX_DEPTH:
                    raise TemplateError("is nested too deeply")
            elif character in ")]}":
                depth = max(0, depth - 1)
    try:
        # Python warns of texts such as '\d', which are common in regular expressions.
        with warnings.catch_warnings(action="ignore"):
            if len(source) > MAX_TOKENS and any(True for _ in islice(_ENVIRONMENT.lex(source), MAX_TOKENS, None)):
                raise TemplateError(f"has more than {MAX_TOKENS} tokens")
            return _ENVIRONMENT.parse(source)
    except jinja2.TemplateSyntaxError as error:
        raise TemplateError(f"is not a valid template: {(error.message or '')[:_MAX_SHOWN_CHARACTERS]}") from error
    except RecursionError:
        raise TemplateError("is nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise TemplateError("has a number or text that cannot be read") from error


_Function: TypeAlias = Callable[..., object]
_Calling: TypeAlias = nodes.Call | nodes.Filter | nodes.Test
_Arguments: TypeAlias = Callable[[Run], tuple[list[object], dict[str, object]]]

_MAX_SHOWN_CHARACTERS = 60
_LARGEST_LITERAL = 64


def parse(source: str) -> Program:
    """Return the program of the template *source*.

    Raises:
        TemplateError: It is no template, or uses an unsupported feature; the problem names it, in a few
            words that follow "the template".
    """
    path = path_program(source)
    if path is not None:
        return path
    tree = tree_of(source)
    compiler = _Compiler()
    try:
        body = compiler.block(tree.body)
    except RecursionError:
        raise TemplateError("is nested too deeply") from None
    missing = (compiler.referenced - compiler.assigned) & HOME_ASSISTANT
    if missing:
        raise TemplateError(f"uses `{min(missing)}`, which only Home Assistant has")
    return Program(body, frozenset(compiler.referenced), compiler.weight)


@final
class _Compiler:
    """Visitor of Jinja's tree; *weight* counts its nodes."""

    def __init__(self) -> None:
        self.referenced: set[str] = set()
        self.assigned: set[str] = set()
        self.weight = 0
        self._depth = 0
        self._loops = 0
        self._in_loop = False

    def block(self, body: Iterable[nodes.Node]) -> Evaluate:
        statements = self._all(body)

        def execute(run: Run) -> None:
            for statement in statements:
                statement(run)

        return execute

    def _compile(self, node: nodes.Node) -> Evaluate:
        visit: Callable[[nodes.Node], Evaluate] | None = getattr(self, f"visit_{type(node).__name__.lower()}", None)
        if visit is None:
            raise TemplateError(f"uses {_describe(node)}, which is not supported")
        self.weight += 1
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise TemplateError("is nested too deeply")
        evaluate = visit(node)
        self._depth -= 1
        return evaluate

    def _all(self, many: Iterable[nodes.Node]) -> tuple[Evaluate, ...]:
        return tuple([self._compile(node) for node in many])

    # Statements

    def visit_output(self, node: nodes.Output) -> Evaluate:
        values = self._all(node.nodes)

        def execute(run: Run) -> None:
            for value in values:
                run.write(value(run))

        return execute

    def visit_if(self, node: nodes.If) -> Evaluate:
        cases = [(self._compile(case.test), self.block(case.body)) for case in (node, *node.elif_)]
        otherwise = self.block(node.else_)

        def execute(run: Run) -> None:
            for test, body in cases:
                if test(run):
                    body(run)
                    return
            otherwise(run)

        return execute

    def visit_for(self, node: nodes.For) -> Evaluate:
        if node.recursive:
            raise TemplateError("uses a recursive loop, which is not supported")
        self._loops += 1
        if self._loops > MAX_FOR_DEPTH:
            raise TemplateError(f"has more than {MAX_FOR_DEPTH} nested loops")
        values = self._compile(node.iter)
        before = self.weight
        target = self._target(node.target)
        test = None if node.test is None else self._compile(node.test)
        body = self._body(node.body, in_loop=True)
        weight = self.weight - before
        self._loops -= 1
        otherwise = self.block(node.else_)

        return Loop(values, target, test, body, otherwise, weight).execute

    def visit_break(self, node: nodes.Node) -> Evaluate:
        return self._jump(node, BreakLoop)

    def visit_continue(self, node: nodes.Node) -> Evaluate:
        return self._jump(node, ContinueLoop)

    def _jump(self, node: nodes.Node, jump: type[Exception]) -> Evaluate:
        if not self._in_loop:
            raise TemplateError(f"uses {_describe(node)} outside a loop")

        def execute(_: Run) -> None:
            raise jump

        return execute

    def visit_assign(self, node: nodes.Assign) -> Evaluate:
        target, value = self._target(node.target), self._compile(node.node)
        return lambda run: target(run, value(run))

    def visit_assignblock(self, node: nodes.AssignBlock) -> Evaluate:
        if node.filter is not None:
            raise TemplateError("uses a filter on a block, which is not supported")
        body = self._body(node.body, in_loop=False)
        target = self._target(node.target)

        def execute(run: Run) -> None:
            start = run.mark()
            with run.scope():
                body(run)
            target(run, run.written(start))

        return execute

    def _body(self, body: Iterable[nodes.Node], *, in_loop: bool) -> Evaluate:
        around, self._in_loop = self._in_loop, in_loop
        compiled = self.block(body)
        self._in_loop = around
        return compiled

    def _target(self, node: nodes.Node) -> Assign:
        self.weight += 1
        if isinstance(node, nodes.Name):
            name = node.name
            self.assigned.add(name)
            return lambda run, value: run.assign(name, value)
        if isinstance(node, nodes.NSRef):
            return _attribute_target(node.name, node.attr)
        if isinstance(node, nodes.Tuple):
            return _tuple_target([self._target(item) for item in node.items])
        raise TemplateError(f"assigns to {_describe(node)}, which is not supported")

    # Expressions

    def visit_templatedata(self, node: nodes.TemplateData) -> Evaluate:
        return _constant(node.data)

    def visit_const(self, node: nodes.Const) -> Evaluate:
        if isinstance(node.value, int) and node.value.bit_length() > _LARGEST_LITERAL:
            raise TemplateError("has a number that is too large")
        return _constant(node.value)

    def visit_name(self, node: nodes.Name) -> Evaluate:
        name, default = node.name, CONSTANTS.get(node.name, UNDEFINED)
        self.referenced.add(name)
        return lambda run: run.lookup(name, default)

    def _sequence(self, node: nodes.List | nodes.Tuple) -> Evaluate:
        kind, items = (list if isinstance(node, nodes.List) else tuple), self._all(node.items)
        return lambda run: run.handle(kind([item(run) for item in items]))

    visit_list = visit_tuple = _sequence

    def visit_dict(self, node: nodes.Dict) -> Evaluate:
        items = [(self._compile(item.key), self._compile(item.value)) for item in node.items]
        return lambda run: run.handle({key(run): value(run) for key, value in items})

    def visit_getattr(self, node: nodes.Getattr) -> Evaluate:
        value, key = self._compile(node.node), node.attr
        return lambda run: item(value(run), key)

    def visit_getitem(self, node: nodes.Getitem) -> Evaluate:
        value = self._compile(node.node)
        if not isinstance(node.arg, nodes.Slice):
            key = self._compile(node.arg)
            return lambda run: item(value(run), key(run))
        bounds = (node.arg.start, node.arg.stop, node.arg.step)
        compiled = [_constant(None) if bound is None else self._compile(bound) for bound in bounds]
        return lambda run: run.handle(slice_of(value(run), [bound(run) for bound in compiled]))

    def visit_condexpr(self, node: nodes.CondExpr) -> Evaluate:
        no = _constant(UNDEFINED) if node.expr2 is None else self._compile(node.expr2)
        test, yes = self._compile(node.test), self._compile(node.expr1)
        return lambda run: yes(run) if test(run) else no(run)

    def _binary(self, node: nodes.BinExpr) -> Evaluate:
        operate, left, right = BINARY[type(node).__name__], self._compile(node.left), self._compile(node.right)
        return lambda run: run.handle(operate(run.handle(left(run)), run.handle(right(run))))

    visit_add = visit_sub = visit_mul = visit_div = visit_floordiv = visit_mod = visit_pow = _binary

    def visit_and(self, node: nodes.And) -> Evaluate:
        left, right = self._compile(node.left), self._compile(node.right)
        return lambda run: left(run) and right(run)

    def visit_or(self, node: nodes.Or) -> Evaluate:
        left, right = self._compile(node.left), self._compile(node.right)
        return lambda run: left(run) or right(run)

    def _unary(self, node: nodes.UnaryExpr) -> Evaluate:
        operate, value = _UNARY[type(node)], self._compile(node.node)
        return lambda run: operate(value(run))

    visit_not = visit_neg = visit_pos = _unary

    def visit_compare(self, node: nodes.Compare) -> Evaluate:
        steps = [(ORDER[operand.op], "in" in operand.op, self._compile(operand.expr)) for operand in node.ops]
        first = self._compile(node.expr)

        def evaluate(run: Run) -> object:
            left = first(run)
            result: object = True
            for compare, is_search, value in steps:
                right = value(run)
                if is_search:
                    run.spend_on_search((left, right))
                result = compare(_count(run, left), _count(run, right))
                if not result:
                    break
                left = right
            return result

        return evaluate

    def visit_concat(self, node: nodes.Concat) -> Evaluate:
        values = self._all(node.nodes)
        return lambda run: run.handle("".join([text(run.handle(value(run))) for value in values]))

    def visit_filter(self, node: nodes.Filter) -> Evaluate:
        if node.node is None or node.name not in FILTERS:
            raise TemplateError(f"uses the filter `{node.name[:_MAX_SHOWN_CHARACTERS]}`, which is not supported")
        function = FILTERS[node.name]
        if node.name not in _DEFAULTS:
            return self._call(function, [node.node, *node.args], node)
        value, arguments = self._compile(node.node), self._arguments(node.args, node)
        is_plain = len(node.args) == 1 and not node.kwargs

        def evaluate_default(run: Run) -> object:
            """Evaluate the default only if it is needed: in ``default(this.state)`` it fails."""
            result = run.handle(value(run))
            if not isinstance(result, Undefined) and (is_plain or result):
                return result
            values, by_name = arguments(run)
            return run.handle(function(run, result, *values, **by_name))

        return evaluate_default

    def visit_test(self, node: nodes.Test) -> Evaluate:
        if node.name not in CHECKS:
            raise TemplateError(f"uses the test `{node.name[:_MAX_SHOWN_CHARACTERS]}`, which is not supported")
        return self._call(CHECKS[node.name], [node.node, *node.args], node)

    def visit_call(self, node: nodes.Call) -> Evaluate:
        called = _DICT if node.node == _DICT_FROM_KEYS else node.node
        if isinstance(called, nodes.Name):
            if called.name == "states" and node.args == [_ITSELF]:
                return UNDEFINED.fail
            if called.name in HOME_ASSISTANT:
                raise TemplateError(f"uses `{called.name}()`, which only Home Assistant has")
            if called.name not in FUNCTIONS:
                raise TemplateError(
                    f"uses the function `{called.name[:_MAX_SHOWN_CHARACTERS]}()`, which is not supported"
                )
            return self._call(FUNCTIONS[called.name], node.args, node)
        if not isinstance(called, nodes.Getattr):
            raise TemplateError("calls something that is not a function")
        if not any(called.attr in methods for methods in METHODS.values()):
            raise TemplateError(f"uses the method `{called.attr[:_MAX_SHOWN_CHARACTERS]}()`, which is not supported")
        method = called.attr

        def call_method(_: Run, owner: object, *values: object, **named: object) -> object:
            if isinstance(owner, Undefined):
                owner.fail()
            return method_of(owner, method)(owner, *values, **named)

        return self._call(call_method, [called.node, *node.args], node)

    def _call(self, function: _Function, arguments: Iterable[nodes.Node], node: _Calling) -> Evaluate:
        """Compile a call of a function that takes the run first."""
        given = self._arguments(arguments, node)

        def evaluate(run: Run) -> object:
            values, by_name = given(run)
            return run.handle(function(run, *values, **by_name))

        return evaluate

    def _arguments(self, arguments: Iterable[nodes.Node], node: _Calling) -> _Arguments:
        if node.dyn_args is not None or node.dyn_kwargs is not None:
            raise TemplateError("calls with `*` or `**`, which is not supported")
        compiled = self._all(arguments)
        named = [
            (keyword.key, self._compile(keyword.value)) for keyword in node.kwargs if isinstance(keyword, nodes.Keyword)
        ]

        def evaluate(run: Run) -> tuple[list[object], dict[str, object]]:
            values = [run.handle(expression(run)) for expression in compiled]
            by_name = {key: run.handle(expression(run)) for key, expression in named}
            run.spend_on_search((*values, *by_name.values()))
            return values, by_name

        return evaluate


_DEFAULTS: Final = frozenset({"d", "default"})

_ITSELF: Final = nodes.Name("entity_id", "load")
"""In ``states(entity_id)``, the last value: as with ``this.state``, a message that asks for it changes nothing."""

_DICT: Final = nodes.Name("dict", "load")
_DICT_FROM_KEYS: Final = nodes.Getattr(_DICT, "from_keys", "load")
"""In the event templates of Zigbee2MQTT 2; a type of mappings, ``dict["from_keys"]``, for Jinja."""

_UNARY: Final[dict[type[nodes.Node], _Function]] = {
    nodes.Not: operator.not_,
    nodes.Neg: operator.neg,
    nodes.Pos: operator.pos,
}


def _constant(value: object) -> Evaluate:
    return lambda _: value


def _attribute_target(name: str, attribute: str) -> Assign:
    def assign(run: Run, value: object) -> None:
        owner = run.lookup(name)
        if not isinstance(owner, Namespace):
            raise TemplateError("only a namespace has attributes that can be set")
        owner.attributes[attribute] = value

    return assign


def _tuple_target(targets: Sequence[Assign]) -> Assign:
    def assign(run: Run, value: object) -> None:
        for target, element in zip(targets, values_of(run, value), strict=True):
            target(run, element)

    return assign


def _count(run: Run, value: object) -> object:
    return run.handle(value) if isinstance(value, (list, tuple, dict)) else value


def _describe(node: nodes.Node) -> str:
    return f"`{type(node).__name__.lower()}`"
