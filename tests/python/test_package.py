"""The package as a whole."""

import tagcal


def test_version() -> None:
    assert tagcal.__version__.count(".") == 2
