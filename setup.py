"""Builds the Python package by CMake: `pip install .` (pyproject.toml has what pip needs to know).

The module is built in build/release if that is configured for this Python, as by tools/setup.sh
--python, else in a folder of its own below build/. TAGCAL_BUILD=FOLDER takes the module that is
built in FOLDER as it stands.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent
MODULE_SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")


def version() -> str:
    text = (ROOT / "CMakeLists.txt").read_text()
    found = re.search(r"^project\(tagcal VERSION ([\d.]+)", text, re.MULTILINE)
    assert found
    return found[1]


def cache_of(folder: Path) -> dict[str, str]:
    """The values of CMake's cache by name; empty if the folder is not configured."""
    cache = folder / "CMakeCache.txt"
    lines = cache.read_text().splitlines() if cache.exists() else []
    matches = [re.match(r"([\w.-]+):\w+=(.*)", line) for line in lines]
    return {match[1]: match[2] for match in matches if match}


def is_on(value: str) -> bool:
    return value.upper() in ("ON", "1", "TRUE", "YES")


def is_for_this_python(folder: Path) -> bool:
    cache = cache_of(folder)
    return (
        is_on(cache.get("TAGCAL_BUILD_PYTHON", ""))
        and not is_on(cache.get("BUILD_SHARED_LIBS", ""))
        and cache.get("PYTHON_MODULE_EXTENSION") == MODULE_SUFFIX
        and cache.get("CMAKE_HOME_DIRECTORY") == str(ROOT)
    )


def configured_folder() -> Path:
    release = ROOT / "build" / "release"
    if is_for_this_python(release):
        return release
    folder = ROOT / "build" / ("pip" + MODULE_SUFFIX.rpartition(".")[0])
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "TAGCAL_BUILD_PYTHON": "ON",
        "TAGCAL_BUILD_TESTS": "OFF",
        "TAGCAL_BUILD_TOOLS": "OFF",
        "Python_EXECUTABLE": sys.executable,  # of this virtual environment, which may be a new one
    }
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    definitions = [f"-D{name}={value}" for name, value in options.items()]
    subprocess.check_call(["cmake", "-S", ROOT, "-B", folder, *generator, *definitions])
    return folder


def built_folder() -> Path:
    if "TAGCAL_BUILD" in os.environ:
        return Path(os.environ["TAGCAL_BUILD"])
    folder = configured_folder()
    jobs = str(os.cpu_count() or 1)
    subprocess.check_call(
        ["cmake", "--build", folder, "--target", "tagcal_python", "--parallel", jobs]
    )
    return folder


class BuildByCMake(build_ext):
    """Puts the module and its types beside the scripts of the package."""

    def build_extension(self, extension: Extension) -> None:
        package = built_folder() / "python" / "tagcal"
        module = package / f"_core{MODULE_SUFFIX}"
        if not module.exists():
            raise SystemExit(f"{package}: has no module for this Python ({module.name})")
        target = Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(module, target)
        types = package / "_core.pyi"
        if types.exists():
            shutil.copy2(types, target.parent)


# Setuptools leaves nothing in the source tree and takes nothing of an earlier run.
with tempfile.TemporaryDirectory() as scratch:
    setup(
        version=version(),
        packages=["tagcal"],
        package_dir={"tagcal": "lib/python/tagcal"},
        package_data={"tagcal": ["py.typed"]},
        ext_modules=[Extension("tagcal._core", sources=[])],
        cmdclass={"build_ext": BuildByCMake},
        options={"build": {"build_base": scratch}, "egg_info": {"egg_base": scratch}},
    )
