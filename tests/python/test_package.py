"""The package as a whole: what `cmake --install` and pip put where."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
import tagcal
import tagcal._core

ROOT = Path(__file__).parents[2]
PACKAGE = Path(tagcal._core.__file__).parent
BUILD = PACKAGE.parents[1]
USUAL = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def run(*command: object, cwd: Path | None = None, **environment: object) -> str:
    every = {**USUAL, **{name: str(value) for name, value in environment.items()}}
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=cwd, env=every, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def files_below(folder: Path) -> set[str]:
    return {
        str(path.relative_to(folder))
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def package_files() -> set[str]:
    """What is installed: the scripts, the module, and its types unless it is built without."""
    names = files_below(ROOT / "lib/python/tagcal")
    return names | {path.name for path in PACKAGE.glob("_core*")}


def imported_from(python: Path, cwd: Path, **environment: object) -> Path:
    """The folder that a Python takes the package from, after it has projected a point with it."""
    program = (
        "import tagcal; camera = tagcal.Camera.pinhole(100, 100, 9, 9, (20, 20));"
        "assert camera.project([0, 0, 1]).tolist() == [9, 9]; print(tagcal.__file__)"
    )
    return Path(run(python, "-c", program, cwd=cwd, **environment).strip()).parent


def test_version() -> None:
    assert f"VERSION {tagcal.__version__} " in (ROOT / "CMakeLists.txt").read_text()


def is_of_debian() -> bool:
    return "deb_system" in sysconfig.get_scheme_names() and sys.prefix == "/usr"


VERSION = f"python{sys.version_info.major}.{sys.version_info.minor}"


@pytest.mark.parametrize(
    "prefix, folder",
    [
        ("/usr", "/usr/lib/python3/dist-packages"),
        ("/usr/local/", f"/usr/local/lib/{VERSION}/dist-packages"),
        ("/opt/some where", f"/opt/some where/lib/{VERSION}/site-packages"),
    ],
)
def test_installed_where_python_looks(prefix: str, folder: str, tmp_path: Path) -> None:
    if not is_of_debian():
        pytest.skip("other folders than Debian's")
    if not prefix.startswith("/opt"):
        assert folder in sys.path
    install = ["cmake", "--install", BUILD, "--component", "python", "--prefix", prefix]
    run(*install, DESTDIR=tmp_path)
    installed = tmp_path / folder[1:]
    assert files_below(tmp_path) == {
        str((installed / "tagcal" / name).relative_to(tmp_path)) for name in package_files()
    }
    found = imported_from(Path(sys.executable), tmp_path, PYTHONPATH=installed)
    assert found == installed / "tagcal"


def test_installed_into_a_virtual_environment(tmp_path: Path) -> None:
    run(sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", tmp_path)
    run("cmake", "--install", BUILD, "--component", "python", "--prefix", tmp_path)
    found = imported_from(tmp_path / "bin" / "python", tmp_path)
    assert found == tmp_path / "lib" / VERSION / "site-packages" / "tagcal"


def source_tree(folder: Path) -> Path:
    """A copy of what setup.py reads."""
    for name in ["pyproject.toml", "setup.py", "README.md", "LICENSE", "CMakeLists.txt"]:
        shutil.copy(ROOT / name, folder)
    shutil.copytree(ROOT / "lib/python/tagcal", folder / "lib/python/tagcal")
    return folder


def pip_install(source: Path, venv: Path, **environment: object) -> Path:
    """Installs as the page says and returns the folder that the package is imported from."""
    run(sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", venv)
    python = venv / "bin" / "python"
    pip = [python, "-m", "pip", "install", "--no-build-isolation", "--no-index", "--no-deps"]
    run(*pip, "--disable-pip-version-check", ".", cwd=source, **environment)
    found = imported_from(python, venv)
    assert found == venv / "lib" / VERSION / "site-packages" / "tagcal"
    return found


def test_pip_takes_a_built_module(tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    source = source_tree(tmp_path / "source")
    before = files_below(source)
    installed = pip_install(source, tmp_path / "venv", TAGCAL_BUILD=BUILD)
    assert files_below(installed) == package_files()
    assert files_below(source) == before


# In the place of the library's, which would take minutes: "builds" the module by copying it.
SMALL_CMAKE = f"""
cmake_minimum_required(VERSION 3.23)
project(tagcal VERSION {tagcal.__version__} LANGUAGES NONE)
if(NOT TAGCAL_BUILD_PYTHON OR TAGCAL_BUILD_TESTS OR TAGCAL_BUILD_TOOLS)
  message(FATAL_ERROR "configured with other options")
endif()
set(PYTHON_MODULE_EXTENSION "{sysconfig.get_config_var("EXT_SUFFIX")}" CACHE INTERNAL "")
add_custom_target(tagcal_python
  COMMAND ${{CMAKE_COMMAND}} -E copy_directory {PACKAGE} ${{PROJECT_BINARY_DIR}}/python/tagcal)
"""


def test_pip_builds_by_cmake(tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    source = source_tree(tmp_path / "source")
    (source / "CMakeLists.txt").write_text(SMALL_CMAKE)
    before = files_below(source)
    pip_install(source, tmp_path / "venv")
    (build,) = (source / "build").iterdir()
    assert build.name.startswith("pip.cpython")
    assert {name for name in files_below(source) if not name.startswith("build/")} == before


def test_the_build_of_set_up_is_used(tmp_path: Path) -> None:
    source = source_tree(tmp_path)
    (source / "CMakeLists.txt").write_text(SMALL_CMAKE)
    options = [f"-DTAGCAL_BUILD_{name}" for name in ["PYTHON=ON", "TESTS=OFF", "TOOLS=OFF"]]
    run("cmake", "-S", source, "-B", source / "build/release", *options)
    run(sys.executable, "setup.py", "build_ext", "--build-lib", source / "to", cwd=source)
    assert [path.name for path in (source / "build").iterdir()] == ["release"]
    assert files_below(source / "to/tagcal") == {path.name for path in PACKAGE.glob("_core*")}
