"""The types of the module (_core.pyi) are complete, and mypy takes them."""

import ast
import os
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Iterator

import pytest
import tagcal
import tagcal._core

ROOT = Path(__file__).parents[2]
STUB = Path(tagcal._core.__file__).parent / "_core.pyi"
PROGRAM = Path(__file__).with_name("typed_program.py")

# What stubtest finds and is so on purpose.
FOUND_BY_STUBTEST = r"""
tagcal\.(_core\.)?[A-Z]\w+  # the metaclass of pybind11
tagcal\._plot\.(Axes|Views)  # for annotations only: matplotlib is loaded when something is drawn
"""

# Where `Any` or `object` is the right type.
ALLOWED = {
    "__eq__": "every object can be compared",
    "to_dict": "its values are of many kinds",
    "from_dict": "its values are of many kinds",
}

# They are made where the module can be imported at build time.
pytestmark = pytest.mark.skipif(not STUB.exists(), reason="the module is built without types")


def definitions() -> Iterator[tuple[str, ast.ClassDef | ast.FunctionDef]]:
    """Public classes and functions, and members of classes, with dotted names."""
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            yield node.name, node
        if isinstance(node, ast.ClassDef):
            for member in node.body:
                if isinstance(member, ast.FunctionDef):
                    yield f"{node.name}.{member.name}", member


def types_of(function: ast.FunctionDef) -> list[str]:
    arguments = function.args
    every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    annotations = [a.annotation for a in every if a.arg != "self"] + [function.returns]
    return [ast.unparse(annotation) if annotation else "" for annotation in annotations]


def run(*arguments: object) -> str:
    """Runs Python, and mypy, with the package that is tested."""
    package = str(STUB.parents[1])
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "MYPYPATH": package, "PYTHONPATH": package},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize(
    "of_pybind, of_python",
    [
        ("f(a: numpy.ndarray[numpy.float64[m, n]]) -> None", "f(a: ArrayLike) -> None"),
        ("f() -> numpy.ndarray[bool]", "f() -> NDArray[np.bool_]"),
        ("f(a: List[int]) -> List[float[3]]", "f(a: Sequence[int]) -> list[float]"),
        ("f(a: int, *, b: str = None) -> None", "f(a: int, *, b: str | None = None) -> None"),
        ("f(a: tagcal.A = <A (1, 2)>) -> tagcal.A", "f(a: A = ...) -> A"),
        ("f(arg0: int, a: str = ', (') -> None", "f(arg0: int, /, a: str = ', (') -> None"),
        ("f(*args, **kwargs) -> None", "f(*args: Any, **kwargs: Any) -> None"),
        (
            "f(a: os.PathLike) -> Optional[os.PathLike]",
            "f(a: str | os.PathLike[str]) -> pathlib.Path | None",
        ),
    ],
)
def test_types_of_pybind_become_those_of_python(of_pybind: str, of_python: str) -> None:
    make_stubs = runpy.run_path(str(ROOT / "lib/python/make_stubs.py"))
    function = make_stubs["translated"](of_pybind, is_method=False)
    assert make_stubs["definition"](function, indent="") == f"def {of_python}"


def test_every_public_name_has_a_type() -> None:
    assert {name.partition(".")[0] for name, _ in definitions()} == set(tagcal._core.__all__)


def test_every_public_name_has_a_docstring() -> None:
    silent = [
        name
        for name, node in definitions()
        if not name.rpartition(".")[2].startswith("__") and not ast.get_docstring(node)
    ]
    assert silent == []


def test_no_type_is_vague() -> None:
    vague = [
        f"{name}: {kind}"
        for name, node in definitions()
        if isinstance(node, ast.FunctionDef) and name.rpartition(".")[2] not in ALLOWED
        for kind in types_of(node)
        if not kind or {"Any", "object", "handle"} & {n.id for n in names_in(kind)}
    ]
    assert vague == []


def names_in(kind: str) -> list[ast.Name]:
    return [node for node in ast.walk(ast.parse(kind)) if isinstance(node, ast.Name)]


def test_program_of_a_user(tmp_path: Path) -> None:
    run("-m", "mypy", "--strict", f"--cache-dir={tmp_path}", PROGRAM)
    first, second = run(PROGRAM).splitlines()
    assert first.startswith("ok 0 ")
    assert second == "matrix: must have the shape (4, 4), got (3, 3)"


def test_types_agree_with_the_module(tmp_path: Path) -> None:
    allowed = tmp_path / "allowed"
    allowed.write_text(FOUND_BY_STUBTEST)
    settings = f"--mypy-config-file={ROOT / 'pyproject.toml'}"
    run("-m", "mypy.stubtest", "tagcal", f"--allowlist={allowed}", settings)
