"""Named tuples that compiled functions pass by reference: one address in place of the numbers of all their arrays.

Numba passes a tuple by value: an array is seven numbers and more, and a tuple of forty arrays some three hundred, in
each call of each function. The compiler spends most of its time on them. Here what the caller in Python passes is
written once to the stack of the entry point, and functions get its address.

In Python, and in compiled functions that make such a tuple themselves, it is a tuple as any other.
"""

import hashlib
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.pythonapi import NativeValue
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, models, register_model, typeof_impl, unbox

_WORD = 8


class Reference(types.Type):
    """Numba type of a tuple that is passed by reference."""

    def __init__(self, made: type, members: tuple[Any, ...]) -> None:
        self.members = dict(zip(made._fields, members, strict=True))  # pyright: ignore[reportAttributeAccessIssue]
        # Names of functions contain those of their arguments; one that lists all members is long.
        digest = hashlib.sha256(repr(members).encode()).hexdigest()[:12]
        super().__init__(name=f"{made.__module__}.{made.__name__}.{digest}")


register_model(Reference)(models.OpaqueModel)


def by_reference(made: Any) -> Any:
    """Let compiled functions pass tuples of this class by reference."""

    @typeof_impl.register(made)
    def typeof(value: Any, context: Any) -> Reference:
        return Reference(made, tuple(typeof_impl(member, context) for member in value))

    return made


@infer_getattr
class _Members(AttributeTemplate):
    key = Reference

    def generic_resolve(self, kind: Reference, name: str) -> Any:
        return kind.members.get(name)


def _words(kind: Any) -> int:
    """Return the size of a member in words: a number or an address has one."""
    if isinstance(kind, ir.Aggregate):
        return sum(map(_words, kind.elements))
    return 1


def _offset(context: Any, kind: Reference, name: str = "") -> int:
    """Return where a member is, in words; by default the size of all."""
    words = 0
    for other, member in kind.members.items():
        if other == name:
            break
        if isinstance(member, Reference):
            words += _offset(context, member)
        else:
            words += _words(context.get_value_type(member))
    return words


def _place(builder: Any, pointer: Any, offset: int) -> Any:
    return builder.gep(pointer, [ir.Constant(ir.IntType(64), _WORD * offset)], inbounds=True)


@lower_getattr_generic(Reference)
def _get(context: Any, builder: Any, kind: Reference, pointer: Any, name: str) -> Any:
    member = kind.members[name]
    place = _place(builder, pointer, _offset(context, kind, name))
    if isinstance(member, Reference):
        return place
    return builder.load(builder.bitcast(place, context.get_value_type(member).as_pointer()))


def _write(kind: Reference, pointer: Any, value: Any, c: Any, is_wrong: Any) -> None:
    """Write the members of a Python tuple to a place in memory."""
    for n, (name, member) in enumerate(kind.members.items()):
        item, place = c.pyapi.tuple_getitem(value, n), _place(c.builder, pointer, _offset(c.context, kind, name))
        if isinstance(member, Reference):
            _write(member, place, item, c, is_wrong)
        else:
            native = c.unbox(member, item)
            c.builder.store(native.value, c.builder.bitcast(place, native.value.type.as_pointer()))
            c.builder.store(c.builder.or_(c.builder.load(is_wrong), native.is_error), is_wrong)


@unbox(Reference)
def _unbox(kind: Reference, value: Any, c: Any) -> NativeValue:
    size = ir.Constant(ir.IntType(64), _offset(c.context, kind))
    with c.builder.goto_entry_block():
        room = c.builder.alloca(ir.IntType(64), size)
    pointer = c.builder.bitcast(room, cgutils.voidptr_t)
    is_wrong = cgutils.alloca_once_value(c.builder, cgutils.false_bit)
    _write(kind, pointer, value, c, is_wrong)
    return NativeValue(pointer, is_error=c.builder.load(is_wrong))
