"""Where a camera is, how it projects, and how far to trust that.

Lengths are metres, angles radians, noise is the standard deviation of one pixel coordinate. Pixel
(0, 0) is the centre of the top-left pixel. `a_from_b` takes coordinates in b to coordinates in a.
"""

from typing import TYPE_CHECKING as _TYPE_CHECKING, Any as _Any

from tagcal._core import *  # noqa: F403
from tagcal._core import __all__ as __all__, __version__ as __version__

if _TYPE_CHECKING:
    from tagcal import plot as plot
else:

    def __getattr__(name: str) -> _Any:  # tagcal.plot is loaded when it is used
        if name == "plot":
            import importlib

            return importlib.import_module("tagcal.plot")
        raise AttributeError(f"module 'tagcal' has no attribute '{name}'")

    def __dir__() -> list[str]:
        return sorted([*globals(), "plot"])
