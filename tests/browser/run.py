"""Runs the tests of this folder, or says what is missing for them and ends with 77 (skipped).

run.py COMMAND [ARGUMENTS OF PYTEST..]    # COMMAND is the built tagcal
"""

import importlib.util
import os
import shutil
import sys
from pathlib import Path

SKIPPED = 77
PROGRAMS = {"TAGCAL_CHROMIUM": "chromium", "TAGCAL_CHROMEDRIVER": "chromedriver"}


def main(command: str, *arguments: str) -> int:
    missing = [name for name in ("pytest", "selenium") if not importlib.util.find_spec(name)]
    for variable, program in PROGRAMS.items():
        os.environ.setdefault(variable, shutil.which(program) or "")
        if not os.environ[variable]:
            missing.append(program)
    if missing:
        print(f"skipped: no {', '.join(missing)} (tools/setup.sh --browser installs them)")
        return SKIPPED
    os.environ["TAGCAL_COMMAND"] = str(Path(command).resolve())
    sys.dont_write_bytecode = True
    import pytest
    return pytest.main(["-q", "-p", "no:cacheprovider", str(Path(__file__).parent), *arguments])


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
