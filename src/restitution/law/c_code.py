"""Translation of compiled functions of numba to C that C++ takes too.

Only what the steps of the contact laws need is translated: numbers, conditions, loops, parts of arrays of one and two
dimensions, and named tuples. A parameter that is an array of NumPy is a pointer. Arrays within named tuples know their
size, and are structures in C. A variable has one type throughout.
"""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from textwrap import indent, wrap
from types import ModuleType
from typing import NamedTuple

WIDTH = 110

_TYPES = {
    "float": "double", "int": "int", "bool": "int", "None": "void", "NDArray": "double *", "Any": "array",
    "tuple[float, float]": "two", "tuple[float, float, float, float]": "four",
}  # fmt: skip
# Arrays that a function only reads.
_READ = ("law", "grip", "way", "moduli", "times")
# Types of the members of named tuples that are no numbers.
_MEMBERS = {
    "weights": "array", "rates": "array", "now": "array", "ends": "array", "counts": "integers", "nodes": "matrix",
    "memory": "matrix", "factors": "matrix", "branches": "matrix",
    "bridge": "matrix", "motion": "matrix", "jumps": "matrix",
}  # fmt: skip
_STRUCTURES = {
    "array": "double *at; int size;", "integers": "int *at; int size;",
    "matrix": "double *at; int rows, size, apart;", "two": "double at[2];", "four": "double at[4];",
}  # fmt: skip
_PLAIN = ("double", "int", "void", "double *", "const double *")
_FUNCTIONS = {"step": "advance", "slide": "drag"}
# Names that are words of C++, or macros of a system.
_NAMES = {"new": "new_", "near": "near_", "far": "far_", "_": "turn"}
_VALUES = {math.nan: "NAN", math.inf: "INFINITY"}
_OPERATORS: dict[type[ast.AST], tuple[str, int]] = {
    ast.Mult: ("*", 12), ast.Div: ("/", 12), ast.FloorDiv: ("/", 12), ast.Mod: ("%", 12), ast.Add: ("+", 11),
    ast.Sub: ("-", 11), ast.Lt: ("<", 9), ast.Gt: (">", 9), ast.LtE: ("<=", 9), ast.GtE: (">=", 9), ast.Eq: ("==", 8),
    ast.NotEq: ("!=", 8), ast.And: ("&&", 4), ast.Or: ("||", 3),
}  # fmt: skip
_ATOM, _UNARY, _PRODUCT, _SUM, _EITHER = 15, 14, 12, 11, 2


class Translated(NamedTuple):
    """Parts of a header: places in arrays as an enumeration, numbers, structures, and functions."""

    places: str
    numbers: str
    structures: str
    functions: str


def translated(prefix: str, modules: Sequence[ModuleType], entries: Sequence[str]) -> Translated:
    """Return functions of modules and what they call among each other, in C, with a start of all names.

    Places and numbers are all of those of the last module, and of the others what the functions use.
    """
    parsed = [node for module in modules for node in ast.parse(inspect.getsource(module)).body]
    # Compiled functions have a decorator; the others are Python's.
    every = {node.name: node for node in parsed if isinstance(node, ast.FunctionDef) and node.decorator_list}
    functions = [every[name] for name in _reached(every, entries)]
    tuples = [
        kind for module in modules for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, tuple) and kind is not NamedTuple
    ]  # fmt: skip
    used = {node.id for function in functions for node in ast.walk(function) if isinstance(node, ast.Name)}
    structures = [kind for kind in dict.fromkeys(tuples) if kind.__name__ in used]
    returned = {node.name: _kind(node.returns) for node in functions}
    scope = _Scope(prefix, returned, {kind.__name__: _members(kind) for kind in structures})
    text = "\n".join(_Function(node, scope).text() for node in functions)
    constants: dict[str, float] = {}
    for module in modules:
        for name, value in vars(module).items():
            if isinstance(value, int | float) and name.isupper() and (module is modules[-1] or name in used):
                plain = name.lstrip("_")
                if constants.setdefault(plain, value) != value:
                    raise ValueError(f"{plain} has two values")
    upper = prefix.upper()
    places = (f"{upper}_{name} = {value}" for name, value in constants.items() if isinstance(value, int))
    numbers = (f"static const double {upper}_{name} = {value!r};" for name, value in constants.items()
               if isinstance(value, float))  # fmt: skip
    return Translated(
        indent(",\n".join(places), "    "), "\n".join(numbers), scope.declarations() if structures else "",
        text.rstrip(),
    )  # fmt: skip


def _reached(functions: dict[str, ast.FunctionDef], entries: Sequence[str]) -> list[str]:
    """Return the names of functions and of those that they call, directly or not, which stand before them."""
    reached: dict[str, None] = {}

    def follow(name: str) -> None:
        for node in ast.walk(functions[name]):
            called = node.func if isinstance(node, ast.Call) else None
            if isinstance(called, ast.Name) and called.id in functions and called.id not in reached:
                follow(called.id)
        reached[name] = None

    for entry in entries:
        follow(entry)
    return list(reached)


def _kind(annotation: ast.expr | None) -> str:
    text = "None" if annotation is None else ast.unparse(annotation)
    return _TYPES.get(text, text)


def _members(kind: type) -> dict[str, str]:
    """Return the types of the members of a named tuple."""
    of_numbers = {float: "double", bool: "int"}
    return {name: _MEMBERS.get(name) or of_numbers[value] for name, value in kind.__annotations__.items()}


class _Scope(NamedTuple):
    """What all functions of a header share: start of names, types that functions return, members of structures."""

    prefix: str
    returned: dict[str, str]
    members: dict[str, dict[str, str]]

    def type(self, kind: str) -> str:
        """Return a type in C."""
        return kind if kind in _PLAIN else f"{self.prefix}_{kind}"

    def variable(self, kind: str, name: str) -> str:
        """Return the declaration of a variable."""
        return f"{self.type(kind)}{' ' * (not kind.endswith('*'))}{name}"

    def function(self, name: str) -> str:
        """Return the name of a function of the law in C."""
        return f"{self.prefix}_{_FUNCTIONS.get(name, name.lstrip('_'))}"

    def declarations(self) -> str:
        """Return the structures, and a function for each that makes one."""
        p = self.prefix
        lines = [f"typedef struct {{ {members} }} {p}_{name};" for name, members in _STRUCTURES.items()]
        lines += [
            "", f"static inline {p}_array {p}_part(double *at, int size)",
            f"{{\n    {p}_array result;\n    result.at = at, result.size = size;\n    return result;\n}}",
            "", f"static inline {p}_matrix {p}_block(double *at, int rows, int size, int apart)",
            f"{{\n    {p}_matrix result;\n    result.at = at, result.rows = rows, result.size = size;\n"
            "    result.apart = apart;\n    return result;\n}",
        ]  # fmt: skip
        for name, count in (("two", 2), ("four", 4)):
            values = ", ".join(f"double v{n}" for n in range(count))
            body = ", ".join(f"result.at[{n}] = v{n}" for n in range(count))
            lines += ["", f"static inline {p}_{name} {p}_make_{name}({values})",
                      f"{{\n    {p}_{name} result;\n    {body};\n    return result;\n}}"]  # fmt: skip
        for name, members in self.members.items():
            parts = "".join(f"    {self.variable(kind, member)};\n" for member, kind in members.items())
            values = ", ".join(self.variable(kind, member) for member, kind in members.items())
            body = "".join(f"    result.{member} = {member};\n" for member in members)
            lines += ["", f"typedef struct {{\n{parts}}} {p}_{name};", "",
                      f"static inline {p}_{name} {p}_make_{name}({values})",
                      f"{{\n    {p}_{name} result;\n{body}    return result;\n}}"]  # fmt: skip
        return "\n".join(lines) + "\n"


class _Function:
    """Translation of one function."""

    def __init__(self, source: ast.FunctionDef, scope: _Scope) -> None:
        self.source, self.scope = source, scope
        self.constants: dict[str, ast.expr] = {}
        self.types: dict[str, str] = {}
        for argument in source.args.args:
            kind = _kind(argument.annotation)
            self.types[argument.arg] = "const double *" if kind == "double *" and argument.arg in _READ else kind

    def text(self) -> str:
        """Return the function in C."""
        source, arguments = self.source, dict(self.types)
        statements = self.block(source.body[1:])
        local = sorted((kind, name) for name, kind in self.types.items() if name not in arguments)
        variables = []
        for kind, names in groupby(local, key=lambda pair: pair[0]):
            stars = "*" * kind.endswith("*")
            plain = self.scope.type(kind).rstrip(" *")
            variables.append(f"{plain} " + ", ".join(stars + self.name(name) for _, name in names))
        used = {node.id for node in ast.walk(source) if isinstance(node, ast.Name)}
        comment = wrap(f"/* {' '.join((ast.get_docstring(source) or '').split())} */", WIDTH, subsequent_indent="   ")
        named = (self.scope.variable(kind, self.name(name)) for name, kind in arguments.items())
        head = f"static inline {self.scope.type(_kind(source.returns))} {self.scope.function(source.name)}"
        unused = "".join(f"    (void){self.name(name)};\n" for name in arguments if name not in used)
        body = "".join(f"    {line};\n" for line in variables) + unused + statements
        return "\n".join(comment) + f"\n{head}({', '.join(named)})\n{{\n{body}}}\n"

    def name(self, name: str) -> str:
        """Return the name of a variable in C."""
        return _NAMES.get(name, name)

    def block(self, statements: list[ast.stmt]) -> str:
        return indent("".join(map(self.statement, statements)), "    ")

    def statement(self, node: ast.stmt) -> str:
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                return "".join(self.unpacked(targets, value))
            case ast.Assign(targets=targets, value=value):
                for target in targets:
                    self.declare(target, self.type_of(value))
                return f"{' = '.join(map(self.expression, targets))} = {self.expression(value)};\n"
            case ast.AugAssign(target=target, op=op, value=value):
                return f"{self.expression(target)} {_OPERATORS[type(op)][0]}= {self.expression(value)};\n"
            case ast.Expr(value=value):
                return f"{self.expression(value)};\n"
            case ast.Return(value=ast.Tuple(elts=values)):
                return f"return {self.result(values)};\n"
            case ast.Return(value=value):
                return f"return {self.expression(value)};\n" if value else "return;\n"
            case ast.Break():
                return "break;\n"
            case ast.Continue():
                return "continue;\n"
            case ast.For() | ast.While():
                return self.loop(node)
            case ast.If(test=test, body=body, orelse=orelse):
                otherwise = f" else {{\n{self.block(orelse)}}}" if orelse else ""
                return f"if ({self.expression(test)}) {{\n{self.block(body)}}}{otherwise}\n"
            case _:
                raise _untranslatable(node)

    def loop(self, node: ast.For | ast.While) -> str:
        match node:
            case ast.While(test=test, body=body):
                return f"while ({self.expression(test)}) {{\n{self.block(body)}}}\n"
            case ast.For(target=ast.Tuple(elts=targets), iter=ast.Tuple(elts=rows), body=body):
                # A loop over pairs of places, written out.
                text = ""
                for row in rows:
                    assert isinstance(row, ast.Tuple)
                    self.constants = {target.id: value for target, value in zip(targets, row.elts, strict=True)
                                      if isinstance(target, ast.Name)}  # fmt: skip
                    text += "".join(map(self.statement, body))
                self.constants = {}
                return text
            case ast.For(target=ast.Name(id=name) as target, iter=ast.Call(func=ast.Name(id="range"), args=limits)):
                self.declare(target, "int")
                first, last = ("0", *(self.expression(limit, _SUM) for limit in limits))[-2:]
                counter = self.name(name)
                head = f"for ({counter} = {first}; {counter} < {last}; {counter}++)"
                return f"{head} {{\n{self.block(node.body)}}}\n"
            case _:
                raise _untranslatable(node)

    def unpacked(self, targets: list[ast.expr], value: ast.expr) -> Iterator[str]:
        """Write one assignment for each of several targets."""
        if isinstance(value, ast.Tuple):
            set_before: set[str] = set()
            for target, each in zip(targets, value.elts, strict=True):
                if set_before & {ast.unparse(node) for node in ast.walk(each) if isinstance(node, ast.expr)}:
                    raise _untranslatable(value)
                set_before.add(ast.unparse(target))
                yield self.statement(ast.Assign([target], each))
            return
        if isinstance(value, ast.Name):
            source = self.name(value.id)
        else:
            source, kind = "unpacked", self.type_of(value)
            self.declare(ast.Name(source), kind)
            yield f"{source} = {self.expression(value)};\n"
        for n, target in enumerate(targets):
            self.declare(target, "double")
            yield f"{self.expression(target)} = {source}.at[{n}];\n"

    def declare(self, target: ast.expr, kind: str) -> None:
        if isinstance(target, ast.Name) and self.types.setdefault(target.id, kind) != kind:
            raise TypeError(f"{target.id} is {self.types[target.id]} and {kind}")

    def type_of(self, node: ast.expr) -> str:
        """Return the type of an expression."""
        match node:
            case ast.Constant(value=value):
                return "int" if isinstance(value, int) else "double"
            case ast.Name(id=name):
                return self.types.get(name, "int")
            case ast.Attribute(value=ast.Name(id=name), attr=attr) if name in self.types:
                return self.scope.members[self.types[name]][attr]
            case ast.Subscript():
                return self.type_of_part(node)
            case ast.Compare() | ast.BoolOp():
                return "int"
            case ast.UnaryOp(operand=operand):
                return self.type_of(operand)
            case ast.IfExp(body=yes, orelse=no):
                return self.common(yes, no)
            case ast.BinOp(left=left, op=op, right=right) if not isinstance(op, ast.Div | ast.Pow):
                return self.common(left, right)
            case ast.Call(func=ast.Name(id="int")):
                return "int"
            case ast.Call(func=ast.Name(id=name), args=args) if name in ("max", "min", "abs"):
                return self.common(*args)
            case ast.Call(func=ast.Name(id=name)):
                return name if name in self.scope.members else self.scope.returned.get(name, "double")
            case _:
                return "double"

    def common(self, *nodes: ast.expr) -> str:
        return "int" if all(self.type_of(node) == "int" for node in nodes) else "double"

    def type_of_part(self, node: ast.Subscript) -> str:
        """Return the type of an element or a part of an array."""
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            return "int"
        whole, sliced = self.type_of(node.value), isinstance(node.slice, ast.Slice)
        if whole.endswith("*"):
            if not sliced:
                return "double"
            return whole if node.slice.upper is None else "array"  # pyright: ignore[reportAttributeAccessIssue]
        if whole == "matrix" and isinstance(node.slice, ast.Tuple):
            slices = [isinstance(part, ast.Slice) for part in node.slice.elts]
            return "matrix" if all(slices) else "array" if any(slices) else "double"
        if whole == "matrix":
            return "array"
        return whole if sliced else {"array": "double", "integers": "int"}[whole]

    def expression(self, node: ast.expr, least: int = 0) -> str:
        """Return an expression in C, in parentheses if it binds less than asked for."""
        text, binds = self.bound(node)
        return f"({text})" if binds < least else text

    def bound(self, node: ast.expr) -> tuple[str, int]:
        """Return an expression in C, and how strongly its outermost operation binds."""
        match node:
            case ast.Constant(value=bool(value)):
                return str(int(value)), _ATOM
            case ast.Constant(value=value):
                return repr(value), _ATOM
            case ast.Name(id=name) if name in self.constants:
                return self.bound(self.constants[name])
            case ast.Name(id=name) if name.isupper() and name not in self.types:
                return f"{self.scope.prefix.upper()}_{name.lstrip('_')}", _ATOM
            case ast.Name(id=name):
                return self.name(name), _ATOM
            case ast.Attribute(value=ast.Name(id="math"), attr=attr):
                value = getattr(math, attr)
                return "NAN" if math.isnan(value) else _VALUES.get(value, repr(value)), _ATOM
            case ast.Attribute(value=value, attr=attr):
                return f"{self.expression(value, _ATOM)}.{attr}", _ATOM
            case ast.Subscript():
                return self.part(node)
            case ast.UnaryOp(op=op, operand=operand):
                sign = "!" if isinstance(op, ast.Not) else "-"
                return f"{sign}{self.expression(operand, _UNARY)}", _UNARY
            case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=2)):
                factor = self.expression(left, _UNARY)
                return f"{factor} * {factor}", _PRODUCT
            case ast.BinOp(left=left, op=op, right=right):
                sign, binds = _OPERATORS[type(op)]
                return f"{self.expression(left, binds)} {sign} {self.expression(right, binds + 1)}", binds
            case ast.BoolOp(op=op, values=values):
                sign, binds = _OPERATORS[type(op)]
                return f" {sign} ".join(self.expression(value, 5) for value in values), binds
            case ast.Compare(left=left, ops=ops, comparators=others):
                terms = []
                for term, op, other in zip([left, *others], ops, others, strict=False):
                    terms.append(self.compared(term, op, other))
                return (" && ".join(terms), 4) if len(terms) > 1 else (terms[0], 8)
            case ast.IfExp(test=test, body=yes, orelse=no):
                return (
                    f"{self.expression(test, 3)} ? {self.expression(yes, 3)} : {self.expression(no, 3)}",
                    _EITHER,
                )
            case ast.Call():
                return self.call(node)
            case _:
                raise _untranslatable(node)

    def compared(self, left: ast.expr, op: ast.cmpop, right: ast.expr) -> str:
        sign, _ = _OPERATORS[type(op)]
        return f"{self.expression(left, 10)} {sign} {self.expression(right, 10)}"

    def part(self, node: ast.Subscript) -> tuple[str, int]:
        """Return an element or a part of an array in C."""
        p, index = self.scope.prefix, node.slice
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            matrix, last = self.type_of(node.value.value) == "matrix", ast.unparse(index) != "0"
            member = "rows" if matrix and not last else "size"
            return f"{self.expression(node.value.value, _ATOM)}.{member}", _ATOM
        whole, kind = self.expression(node.value, _ATOM), self.type_of(node.value)
        if kind.endswith("*"):
            if not isinstance(index, ast.Slice):
                return f"{whole}[{self.expression(index)}]", _ATOM
            if index.upper is None:
                assert index.lower is not None
                return f"{whole} + {self.expression(index.lower, _SUM + 1)}", _SUM
            return f"{p}_part((double *){whole}{self.offset(index)}, {self.length(index)})", _ATOM
        if kind == "matrix":
            row, column = index.elts if isinstance(index, ast.Tuple) else (index, ast.Slice())
            if isinstance(row, ast.Slice):
                assert isinstance(column, ast.Slice)
                sizes = f"{whole}.rows, {self.length(column)}, {whole}.apart"
                return f"{p}_block({whole}.at{self.offset(column)}, {sizes})", _ATOM
            start = f"{self.expression(row, _PRODUCT)} * {whole}.apart"
            if not isinstance(column, ast.Slice):
                return f"{whole}.at[{start} + {self.expression(column, _SUM)}]", _ATOM
            size = f"{whole}.size" if column.upper is None else self.length(column)
            return f"{p}_part({whole}.at + {start}{self.offset(column)}, {size})", _ATOM
        if isinstance(index, ast.Slice):
            return f"{p}_part({whole}.at{self.offset(index)}, {self.length(index)})", _ATOM
        return f"{whole}.at[{self.expression(index)}]", _ATOM

    def offset(self, part: ast.Slice) -> str:
        return "" if part.lower is None else f" + {self.expression(part.lower, _SUM + 1)}"

    def length(self, part: ast.Slice) -> str:
        if part.upper is None:
            raise _untranslatable(part)
        upper = self.expression(part.upper, _SUM)
        return upper if part.lower is None else f"{upper} - {self.expression(part.lower, _SUM + 1)}"

    def result(self, values: Sequence[ast.expr]) -> str:
        """Return a structure of two or four numbers."""
        kind = {2: "two", 4: "four"}[len(values)]
        return f"{self.scope.prefix}_make_{kind}({', '.join(map(self.expression, values))})"

    def call(self, node: ast.Call) -> tuple[str, int]:
        arguments = [self.result(each.elts) if isinstance(each, ast.Tuple) else self.expression(each)
                     for each in node.args]  # fmt: skip
        match node.func:
            case ast.Name(id="int"):
                return f"(int){self.expression(node.args[0], _UNARY)}", _UNARY
            case ast.Name(id=name) if name in ("max", "min") and self.common(*node.args) == "int":
                first, second = (self.expression(each, 10) for each in node.args)
                sign = ">" if name == "max" else "<"
                return f"{first} {sign} {second} ? {first} : {second}", _EITHER
            case ast.Name(id=name) if name in ("max", "min", "abs"):
                return f"f{name}({', '.join(arguments)})", _ATOM
            case ast.Name(id=name) if name in self.scope.members:
                return f"{self.scope.prefix}_make_{name}({', '.join(arguments)})", _ATOM
            case ast.Name(id=name):
                return f"{self.scope.function(name)}({', '.join(arguments)})", _ATOM
            case ast.Attribute(attr=attr):
                return f"{attr}({', '.join(arguments)})", _ATOM
            case _:
                raise _untranslatable(node)


def _untranslatable(node: ast.AST) -> TypeError:
    return TypeError(f"no translation to C: {ast.unparse(node)}")
