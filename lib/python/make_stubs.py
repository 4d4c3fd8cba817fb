"""Writes _core.pyi, the types of the module, from the docstrings that pybind11 makes.

    make_stubs.py FOLDER    # which has tagcal/_core; writes FOLDER/tagcal/_core.pyi

A docstring begins with the signature, or has a numbered list of overloads. Its types are those of
C++: this program turns them into types of Python, such as numpy.ndarray[numpy.float64[3, 3]] into
NDArray[np.float64].
"""

import ast
import importlib
import re
import sys
import textwrap
from pathlib import Path
from types import ModuleType
from typing import Iterator, NamedTuple

MODULE = "tagcal._core"
HEADER = f'''\
# Written by lib/python/make_stubs.py from the docstrings of the module.
import os
import pathlib
from typing import Any, Callable, ClassVar, Iterator, NoReturn, Sequence, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
'''

# Types of arguments and of results where they differ from each other or from their C++ names.
ARGUMENTS = {
    "os.PathLike": "str | os.PathLike[str]",
    "numpy.ndarray": "ArrayLike",
    "List": "Sequence",
    "OutputArray": "NDArray[np.float64]",
    "ImageLike": "NDArray[np.uint8] | NDArray[np.uint16] | str | os.PathLike[str]",
    "PoseLike": "Pose | ArrayLike",
    "PosesLike": "Pose | ArrayLike | Sequence[Pose | ArrayLike]",
    "SeenPoseLike": "PoseEstimate | RigPoseEstimate | tuple[Pose | ArrayLike, ArrayLike] | None",
    "CameraLike": "Camera | UncertainCamera | Calibration",
    "tagcal.Dataset": "Dataset | DatasetFolder",
    "TargetLike": "Board | PlacedBoard | Sequence[Board | PlacedBoard]",
}
RESULTS = {
    "os.PathLike": "pathlib.Path",
    "numpy.ndarray": "NDArray[Any]",
    "List": "list",
}
PYBIND11_2_12 = {"list": "List", "dict": "Dict", "set": "Set", "tuple": "Tuple"}
BOTH = {
    "Dict": "dict",
    "Set": "set",
    "Tuple": "tuple",
    "dict": "dict[str, Any]",
    "list": "list[Any]",
    "tuple": "tuple[Any, ...]",
}


class Signature(NamedTuple):
    """One overload."""

    text: str  # name(arguments) -> result
    doc: str


def expression(text: str) -> ast.expr:
    (statement,) = ast.parse(text).body
    assert isinstance(statement, ast.Expr)
    return statement.value


class TypeOfPython(ast.NodeTransformer):
    """Turns the expression of a type of pybind11 into one of Python."""

    def __init__(self, names: dict[str, str]) -> None:
        self.names = {**BOTH, **names}

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return expression(self.names.get(node.id, node.id))

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        name = ast.unparse(node)
        if name in self.names:
            return expression(self.names[name])
        return expression(name.replace("tagcal.", "", 1).replace("numpy.", "np.", 1))

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        name = ast.unparse(node.value)
        if name == "numpy.ndarray":
            return self.array(node.slice)
        if isinstance(node.slice, ast.Constant):  # a std::array is List[float[3]]
            return expression(ast.unparse(self.visit(node.value)))
        if name == "Annotated" and isinstance(node.slice, ast.Tuple):  # so by pybind11 2.12
            return expression(ast.unparse(self.visit(node.slice.elts[0])))
        name = PYBIND11_2_12.get(name, name)
        items = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        types = [ast.unparse(self.visit(item)) for item in items]
        if name == "Optional":
            return expression(f"{types[0]} | None")
        if name == "Union":
            return expression(" | ".join(types))
        return expression(f"{self.names.get(name, name)}[{', '.join(types)}]")

    def array(self, element: ast.expr) -> ast.expr:
        """`element`: numpy.float64, numpy.float64[m, n], or one of these and flags."""
        if self.names["numpy.ndarray"] == "ArrayLike":
            return expression("ArrayLike")
        if isinstance(element, ast.Tuple):
            element = element.elts[0]
        if isinstance(element, ast.Subscript):
            element = element.value
        kind = ast.unparse(self.visit(element))
        return expression("NDArray[np.bool_]" if kind == "bool" else f"NDArray[{kind}]")


def is_literal(node: ast.expr) -> bool:
    try:
        ast.literal_eval(node)
    except ValueError:
        return False
    return True


def translated(text: str, is_method: bool) -> ast.FunctionDef:
    """The definition with types of Python. `text`: name(arguments) -> result."""
    text = re.sub(r"= <[^>]*>", "= ...", text)  # a default of a class without a literal
    try:
        (function,) = ast.parse(f"def {text}: ...").body
    except SyntaxError as error:  # a type of C++, such as tagcal::Camera, that Python has not got
        raise SystemExit(f"{text}: bind the classes of its types before it") from error
    assert isinstance(function, ast.FunctionDef)
    arguments = function.args
    if is_method:
        arguments.args[0] = ast.arg("self")
    for argument in [*arguments.args[is_method:], *arguments.kwonlyargs]:
        assert argument.annotation
        argument.annotation = TypeOfPython(ARGUMENTS).visit(argument.annotation)
    unnamed = [i for i, a in enumerate(arguments.args) if re.fullmatch(r"arg\d+", a.arg)]
    if unnamed:  # by position only
        arguments.posonlyargs = arguments.args[: unnamed[-1] + 1]
        arguments.args = arguments.args[unnamed[-1] + 1 :]
    make_optional(arguments)
    assert function.returns
    function.returns = TypeOfPython(RESULTS).visit(function.returns)
    return function


def make_optional(arguments: ast.arguments) -> None:
    """An argument with the default None may be None; other defaults are literals or `...`."""
    positional = arguments.posonlyargs + arguments.args
    with_default = positional[len(positional) - len(arguments.defaults) :] + arguments.kwonlyargs
    for argument, default in zip(with_default, [*arguments.defaults, *arguments.kw_defaults]):
        assert argument.annotation
        is_none = isinstance(default, ast.Constant) and default.value is None
        if is_none and not ast.unparse(argument.annotation).endswith("| None"):
            argument.annotation = expression(f"{ast.unparse(argument.annotation)} | None")
    arguments.defaults = [d if is_literal(d) else expression("...") for d in arguments.defaults]
    arguments.kw_defaults = [
        d if d is None or is_literal(d) else expression("...") for d in arguments.kw_defaults
    ]


def argument_text(argument: ast.arg, default: "ast.expr | None") -> str:
    text = argument.arg
    if argument.annotation:
        text += ": " + ast.unparse(argument.annotation)
    return text + (f" = {ast.unparse(default)}" if default else "")


def argument_texts(arguments: ast.arguments) -> Iterator[str]:
    positional = arguments.posonlyargs + arguments.args
    required = len(positional) - len(arguments.defaults)
    for i, argument in enumerate(positional):
        yield argument_text(argument, arguments.defaults[i - required] if i >= required else None)
        if i + 1 == len(arguments.posonlyargs):
            yield "/"
    if arguments.vararg:
        yield f"*{arguments.vararg.arg}: Any"
    elif arguments.kwonlyargs:
        yield "*"
    for argument, value in zip(arguments.kwonlyargs, arguments.kw_defaults):
        yield argument_text(argument, value)
    if arguments.kwarg:
        yield f"**{arguments.kwarg.arg}: Any"


def definition(function: ast.FunctionDef, indent: str) -> str:
    """def name(arguments) -> result, in lines of at most 100 columns where it is possible."""
    assert function.returns
    arguments = list(argument_texts(function.args))
    end = f") -> {ast.unparse(function.returns)}"
    line = f"{indent}def {function.name}({', '.join(arguments)}{end}"
    if len(line) < 100:
        return line
    lines = "".join(f"{indent}    {argument},\n" for argument in arguments)
    return f"{indent}def {function.name}(\n{lines}{indent}{end}"


def signatures(doc: str, name: str) -> list[Signature]:
    head, _, rest = doc.partition("\n")
    if not rest.startswith("Overloaded function."):
        return [Signature(head, rest.strip())]
    parts = re.split(rf"^\d+\. (?={re.escape(name)}\()", rest, flags=re.MULTILINE)[1:]
    return [Signature(part.partition("\n")[0], part.partition("\n")[2].strip()) for part in parts]


def docstring(text: str, indent: str) -> str:
    text = text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    lines: list[str] = []
    for paragraph in text.split("\n"):
        lines += textwrap.wrap(paragraph, 95 - len(indent)) or [""]
    if len(lines) > 1 or text.endswith('"'):
        lines.append("")
    return f'{indent}"""' + f"\n{indent}".join(lines).replace(f"\n{indent}\n", "\n\n") + '"""\n'


def functions(name: str, doc: str, indent: str, decorator: str = "") -> Iterator[str]:
    """The definitions of a function. `decorator`: "staticmethod", or "" for those with `self`."""
    overloads = signatures(doc, name)
    for signature in overloads:
        is_method = bool(indent) and decorator != "staticmethod"
        yield "\n"
        if len(overloads) > 1:
            yield f"{indent}@overload\n"
        if decorator:
            yield f"{indent}@{decorator}\n"
        head = definition(translated(signature.text, is_method), indent)
        yield head + (":\n" if signature.doc else ": ...\n")
        if signature.doc:
            yield docstring(signature.doc, indent + "    ")


def property_lines(name: str, member: property, indent: str) -> Iterator[str]:
    getter = (member.fget.__doc__ or "").strip().partition("\n")[0]
    result = ast.unparse(translated(f"{name}{getter}", True).returns or expression("None"))
    yield f"\n{indent}@property\n{indent}def {name}(self) -> {result}:\n"
    yield docstring(member.__doc__ or "", indent + "    ")
    if member.fset:
        value = translated(f"{name}{(member.fset.__doc__ or '').strip()}", True).args
        kind = ast.unparse([*value.posonlyargs, *value.args][1].annotation or expression("Any"))
        yield f"\n{indent}@{name}.setter\n"
        yield f"{indent}def {name}(self, value: {kind}) -> None: ...\n"


def class_lines(cls: type) -> Iterator[str]:
    base = cls.__bases__[0].__name__
    yield f"\nclass {cls.__name__}" + ("" if base == "pybind11_object" else f"({base})") + ":\n"
    yield docstring(cls.__doc__ or "", "    ")
    if base == "pybind11_object" and "__init__(" not in str(vars(cls)["__init__"].__doc__):
        yield "\n    def __init__(self, *args: NoReturn, **kwargs: NoReturn) -> None:\n"
        yield docstring("Made by functions only.", "        ")
    for name, member in vars(cls).items():
        doc = getattr(cls, name).__doc__ or ""
        if isinstance(member, property):
            yield from property_lines(name, member, "    ")
        elif isinstance(member, staticmethod):
            yield from functions(name, doc, "    ", "staticmethod")
        elif name == "__hash__" and member is None:
            yield "\n    __hash__: ClassVar[None]  # type: ignore[assignment]\n"
        elif doc.startswith(f"{name}(") and name not in ("__getstate__", "__setstate__"):
            yield from functions(name, doc, "    ")


def stub_lines(module: ModuleType) -> Iterator[str]:
    yield HEADER
    yield "\n__version__: str\n__all__ = [\n"
    yield from (f'    "{name}",\n' for name in module.__all__)
    yield "]\n"
    for name in module.__all__:
        member = getattr(module, name)
        if isinstance(member, type):
            yield from class_lines(member)
        else:
            yield from functions(name, member.__doc__, "")


def main(folder: Path) -> None:
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(folder))
    module = importlib.import_module(MODULE)
    assert module.__file__
    path = Path(module.__file__).parent / "_core.pyi"
    path.write_text("".join(stub_lines(module)), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
