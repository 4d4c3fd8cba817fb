"""What is wrong with a call whose arguments fit no signature, in one line."""

import difflib
import operator
import os
import re
from dataclasses import dataclass
from typing import Any, Optional

from tagcal import _core


@dataclass(frozen=True)
class Parameter:
    name: str
    kind: str  # as pybind11 writes it, such as "Optional[tagcal.Camera]"
    is_required: bool
    by_name_only: bool


Signature = list[Parameter]

# Types as users say them; those that are not here are checked by the function itself.
NAMES = {
    "int": "a whole number",
    "float": "a number",
    "bool": "True or False",
    "str": "a text",
    "os.PathLike": "the path of a file",
    "List": "a list",
    "Dict": "a dictionary",
}


def split(text: str) -> list[str]:
    """The parts of a list at its commas outside of brackets and quotes."""
    parts, depth, start, quote = [], 0, 0, ""
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        else:
            depth += (c in "[(<{") - (c in "])>}")
            if c == "," and depth == 0:
                parts.append(text[start:i].strip())
                start = i + 1
    return [*parts, text[start:].strip()] if text.strip() else []


def signature(text: str) -> Signature:
    parameters, by_name_only = [], False
    for part in split(text):
        if part == "*":
            by_name_only = True
            continue
        name, _, rest = part.partition(":")
        kind, _, default = rest.partition(" = ")
        parameters.append(Parameter(name.strip(), kind.strip(), not default, by_name_only))
    return parameters


def opened(kind: str) -> tuple[str, str]:
    """The outer and inner part of a type. pybind11 2.12 and newer write list instead of List."""
    outer, _, inner = kind.removesuffix("]").partition("[")
    if outer == "Annotated":  # a std::array, with its size
        return opened(split(inner)[0])
    return ({"list": "List", "dict": "Dict"}.get(outer, outer) if inner else outer), inner


def fits(value: Any, kind: str) -> bool:
    outer, inner = opened(kind)
    if outer == "Optional":
        return value is None or fits(value, inner)
    if outer == "Union":
        return any(fits(value, part) for part in split(inner))
    if kind == "tagcal.Dataset":
        return isinstance(value, (_core.Dataset, _core.DatasetFolder))
    if kind.startswith("tagcal."):
        return isinstance(value, getattr(_core, kind[len("tagcal.") :]))
    if kind == "int":
        try:
            operator.index(value)
        except TypeError:
            return False
        return True
    if kind == "float":
        return hasattr(value, "__float__") or hasattr(value, "__index__")
    if kind == "bool":
        return type(value).__name__ in ("bool", "bool_")
    if kind in ("str", "os.PathLike"):
        return isinstance(value, (str, bytes) if kind == "str" else (str, bytes, os.PathLike))
    if outer == "List":
        element = re.sub(r"\[\d+\]$", "", inner)  # a std::array is List[float[3]]
        return hasattr(value, "__len__") and not isinstance(value, str) and all(
            fits(v, element) for v in value
        )
    return isinstance(value, dict) if outer == "Dict" else True


def said(kind: str) -> str:
    outer, inner = opened(kind)
    if outer == "Optional":
        return said(inner) + " or None"
    if outer == "Union":
        return " or ".join(map(said, split(inner)))
    if outer == "List":
        return "a list of " + re.sub(r"^an? ", "", said(re.sub(r"\[\d+\]$", "", inner)))
    return NAMES.get(outer, f"a {kind.rpartition('.')[2]}")


def type_said(value: object) -> str:
    return "None" if value is None else type(value).__name__


def problems(
    label: str, parameters: Signature, arguments: tuple[Any, ...], named: dict[str, Any]
) -> list[str]:
    """What speaks against this signature, the first reason first."""
    found = []
    names = [p.name for p in parameters]
    by_place = [p for p in parameters if not p.by_name_only]
    for name in named:
        if name not in names:
            found.append(f"{label} has no argument '{name}'")
    if len(arguments) > len(by_place):
        if len(parameters) > len(by_place):
            found.append(f"{label}: arguments after '{by_place[-1].name}' are named")
        else:
            found.append(f"{label} has {len(by_place)} arguments, got {len(arguments)}")
    values = dict(zip([p.name for p in by_place], arguments))
    found += [f"{label} got '{name}' twice" for name in values if name in named]
    values.update(named)
    for p in parameters:
        if p.name not in values:
            if p.is_required:
                found.append(f"{label} needs the argument '{p.name}'")
        elif not fits(values[p.name], p.kind):
            got = type_said(values[p.name])
            found.append(f"{label}: {p.name}: must be {said(p.kind)}, got {got}")
    return found


def suggestion(name: str, names: list[str]) -> str:
    near = difflib.get_close_matches(name, names, 1)
    if near:
        return f": did you mean '{near[0]}'?"
    return f": it has {', '.join(names)}" if names else ""


def sentence(text: str, arguments: tuple[Any, ...], named: Optional[dict[str, Any]]) -> str:
    """One line for the error of pybind11: `text` has the signatures."""
    named = named or {}
    head = text.partition("(")[0]
    lines = re.findall(r"^    \d+\. ([\w.]*)\((.*)\)(?: -> .*)?$", text, re.MULTILINE)
    signatures = [signature(inside) for _, inside in lines]
    if head == "__init__":
        label = lines[0][0].rpartition(".")[2] + "()"
        arguments = arguments[1:]  # self
    elif signatures and signatures[0] and signatures[0][0].name == "self":
        label = f"{signatures[0][0].kind.rpartition('.')[2]}.{head}()"
        signatures = [s[1:] for s in signatures]
        arguments = arguments[1:]
    else:
        label = head + "()"
    names = list(dict.fromkeys(p.name for s in signatures for p in s))
    for name in named:
        if name not in names:
            return f"{label} has no argument '{name}'" + suggestion(name, names)
    found = [problems(label, s, arguments, named) for s in signatures]
    best = min(found, key=len)
    if best:
        return best[0]
    given = [*map(type_said, arguments), *(f"{k}={type_said(v)}" for k, v in named.items())]
    return f"{label} takes ({', '.join(names)}), got ({', '.join(given)})"
