"""The contact law as a C99 header: the compiled functions of `step` and `slide`, translated, and constants of one law.

Only what the step needs is translated: numbers, conditions, loops over a range, and parts of arrays, which become
pointers.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Sequence
from importlib.resources import files
from itertools import groupby
from string import Template
from textwrap import indent, wrap

from restitution.law import slide, step

_TYPES = {"float": "double", "int": "int", "bool": "int", "None": "void"}
_WORDS: dict[type[ast.AST], str] = {ast.And: " && ", ast.Or: " || "}
_NAMES = {"max": "fmax", "min": "fmin", "abs": "fabs", "step": "advance", "slide": "drag"}
# Arrays that a function only reads.
_READ = ("law", "grip", "way", "moduli", "times")
_VALUES = {"nan": "NAN", "inf": "INFINITY", "True": "1", "False": "0"}
_WIDTH = 110


# The tangential half, behind the normal one.
_SLIDE = """

/* Constants of friction; see the module restitution.law.slide. */
static const double {name}_grip[{count}] = {{
{constants}
}};
"""
_CALL = """

/* Advance the tangential half of a contact after {name}_step, which has returned the force: way [m] of the contact
   points past each other in the step, and pull [N], the force that resists it, along two axes at right angles. */
static inline void {name}_slide(double *state, double force, const double *way, double dt, double *pull)
{{
    {name}_drag({name}_constants, {name}_grip, state, force, way, dt, pull);
}}
"""


def header(
    name: str,
    paragraphs: Sequence[str],
    constants: Sequence[tuple[float, str]],
    size: int,
    grip: Sequence[tuple[float, str]] = (),
) -> str:
    """Return the text of a header.

    Parameters
    ----------
    name
        Start of all names in the header.
    paragraphs
        What the law is.
    constants, size
        The constants, each with its meaning, and the length of a state.
    grip
        The constants of friction, if the law has a tangential force.
    """
    modules = [step, slide] if grip else [step]
    upper = name.upper()
    places = {key: value for module in modules for key, value in vars(module).items() if isinstance(value, int)}
    numbers = {key: value for module in modules for key, value in vars(module).items() if isinstance(value, float)}
    parsed = [node for module in modules for node in ast.parse(inspect.getsource(module)).body]
    # Compiled functions have a decorator; the others are Python's.
    functions = [node for node in parsed if isinstance(node, ast.FunctionDef) and node.decorator_list]
    returned = {node.name: _TYPES[ast.unparse(node.returns)] for node in functions if node.returns}
    translated = [
        _Function(node, returned, name).text() for node in functions if node.name not in ("step_all", "slide_all")
    ]
    template = files("restitution.law").joinpath("contact_law.h.template").read_text(encoding="utf-8")
    slid = _SLIDE.format(name=name, count=len(grip), constants=_listed(grip)).rstrip() if grip else ""
    return Template(template).substitute(
        text="\n".join(line for text in paragraphs for line in wrap(_safe(text), _WIDTH) or [""]),
        guard=f"{upper}_H", upper=upper, name=name, size=size, count=len(constants),
        places=indent(",\n".join(f"{upper}_{key} = {value}" for key, value in places.items()), "    "),
        numbers="\n".join(f"static const double {upper}_{key} = {value!r};" for key, value in numbers.items()),
        constants=_listed(constants), slid=slid, call=_CALL.format(name=name).rstrip() if grip else "",
        functions="\n".join(translated).rstrip(),
    )  # fmt: skip


def _listed(constants: Sequence[tuple[float, str]]) -> str:
    entries = [f"{_VALUES.get(repr(value), repr(value))}, /* {_safe(meaning)} */" for value, meaning in constants]
    return indent("\n".join(entries), "    ")


def _safe(text: str) -> str:
    """Return a text that does not end a comment."""
    return text.replace("*/", "* /").replace("/*", "/ *")


class _Function(ast.NodeTransformer):
    """Translation of one function to C; a variable has one type throughout."""

    def __init__(self, source: ast.FunctionDef, returned: dict[str, str], prefix: str) -> None:
        self.source, self.returned, self.prefix = source, returned, prefix
        self.types: dict[str, str] = {}
        for argument in source.args.args:
            annotation = ast.unparse(argument.annotation or argument)
            pointer = "const double *" if argument.arg in _READ else "double *"
            self.types[argument.arg] = pointer if annotation == "NDArray" else _TYPES[annotation]

    def text(self) -> str:
        source, arguments = self.source, dict(self.types)
        statements = self.block(source.body[1:])
        local = sorted((kind, name) for name, kind in self.types.items() if name not in arguments)
        variables = [
            f"{kind.rstrip(' *')} " + ", ".join("*" * kind.endswith("*") + name for _, name in names)
            for kind, names in groupby(local, key=lambda pair: pair[0])
        ]
        comment = wrap(f"/* {' '.join((ast.get_docstring(source) or '').split())} */", _WIDTH, subsequent_indent="   ")
        named = (f"{kind}{' ' * (not kind.endswith('*'))}{name}" for name, kind in arguments.items())
        head = f"static inline {self.returned[source.name]} {self.function(source.name)}({', '.join(named)})"
        body = "".join(f"    {line};\n" for line in variables) + statements
        return "\n".join(comment) + f"\n{head}\n{{\n{body}}}\n"

    def function(self, name: str) -> str:
        """Return the name of a function of the step, or of the library of C."""
        new = _NAMES.get(name, name)
        return f"{self.prefix}_{new}" if name in self.returned else new

    def block(self, statements: list[ast.stmt]) -> str:
        return indent("".join(map(self.statement, statements)), "    ")

    def statement(self, node: ast.stmt) -> str:
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Tuple(elts=values)):
                pairs = zip(targets, values, strict=True)
                return "".join(self.statement(ast.Assign([target], value)) for target, value in pairs)
            case ast.Assign(targets=[target]):
                self.declare(target, self.type_of(node.value))
                return f"{self.expression(target)} = {self.expression(node.value)};\n"
            case ast.AugAssign():
                return f"{ast.unparse(self.visit(node))};\n"
            case ast.Expr():
                return f"{self.expression(node.value)};\n"
            case ast.Return(value=value):
                return f"return {self.expression(value)};\n" if value else "return;\n"
            case ast.For(target=ast.Name(id=name), iter=ast.Call(args=limits)):
                self.declare(node.target, "int")
                first, last = ("0", *map(self.expression, limits))[-2:]
                return f"for ({name} = {first}; {name} < {last}; {name}++) {{\n{self.block(node.body)}}}\n"
            case ast.While():
                return f"while ({self.expression(node.test)}) {{\n{self.block(node.body)}}}\n"
            case ast.If():
                otherwise = f" else {{\n{self.block(node.orelse)}}}" if node.orelse else ""
                return f"if ({self.expression(node.test)}) {{\n{self.block(node.body)}}}{otherwise}\n"
            case _:
                raise TypeError(f"no translation to C: {ast.unparse(node)}")

    def declare(self, target: ast.expr, kind: str) -> None:
        if isinstance(target, ast.Name) and self.types.setdefault(target.id, kind) != kind:
            raise TypeError(f"{target.id} is {self.types[target.id]} and {kind}")

    def type_of(self, node: ast.expr) -> str:
        match node:
            case ast.Constant(value=value):
                return "int" if isinstance(value, int) else "double"
            case ast.Name(id=name):
                return self.types.get(name, "int")
            case ast.Subscript(value=value, slice=ast.Slice()):
                return self.type_of(value)
            case ast.BinOp(left=left, op=op, right=right) if not isinstance(op, ast.Div):
                return "int" if self.type_of(left) == self.type_of(right) == "int" else "double"
            case ast.Call(func=ast.Name(id=name)):
                return self.returned.get(name, "int" if name == "int" else "double")
            case _:
                return "double"

    def expression(self, node: ast.expr) -> str:
        """Return an expression in C, which Python writes after the names and operators are replaced."""
        return ast.unparse(self.visit(node))

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        return ast.Name(_VALUES.get(repr(node.value), repr(node.value)))

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return ast.Name(f"{self.prefix.upper()}_{node.id}" if node.id.isupper() else node.id)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return ast.Name(_VALUES.get(node.attr, node.attr))

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if isinstance(node.slice, ast.Slice) and node.slice.lower is not None:
            return self.visit(ast.BinOp(node.value, ast.Add(), node.slice.lower))
        return self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        if isinstance(node.op, ast.FloorDiv):
            node = ast.BinOp(node.left, ast.Div(), node.right)
        return self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        if len(node.ops) > 1:
            raise TypeError(f"no translation to C: {ast.unparse(node)}")
        return self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        return ast.Name("(" + _WORDS[type(node.op)].join(f"({self.expression(value)})" for value in node.values) + ")")

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        if isinstance(node.op, ast.Not):
            return ast.Name(f"!({self.expression(node.operand)})")
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        arguments = [self.visit(argument) for argument in node.args]
        if isinstance(node.func, ast.Name):
            if node.func.id == "int":
                return ast.Name(f"(int){ast.unparse(arguments[0])}")
            return ast.Call(ast.Name(self.function(node.func.id)), arguments, [])
        return ast.Call(self.visit(node.func), arguments, [])
