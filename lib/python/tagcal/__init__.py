"""Where a camera is, how it projects, and how far to trust that.

Lengths are metres, angles radians, noise is the standard deviation of one pixel coordinate. Pixel
(0, 0) is the centre of the top-left pixel. `a_from_b` takes coordinates in b to coordinates in a.
"""

from typing import TYPE_CHECKING as _TYPE_CHECKING, Any as _Any

# Without __all__, with which `help(tagcal)` would print every class in full.
from tagcal import _core
from tagcal._core import *  # noqa: F403
from tagcal._core import __version__ as __version__
from tagcal._report import report as report, table_of as _table_of

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

    def _classes() -> str:
        values = [(name, getattr(_core, name)) for name in _core.__all__]
        lines = [
            f"{name}: {str(value.__doc__).partition('. ')[0].partition(chr(10))[0].rstrip('.')}"
            for name, value in values
            if isinstance(value, type)
        ]
        return "\n".join(lines)

    __doc__ = f"{__doc__}\nClasses, of which `help(tagcal.NAME)` says more:\n\n{_classes()}\n"
    report.__module__ = __name__
    setattr(_core.Calibration, "_repr_html_", _table_of)
