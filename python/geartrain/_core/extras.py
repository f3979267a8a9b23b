"""Packages that some calls need and the others do without."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["OPTIONAL", "cure", "extra", "missing"]

#: The optional dependencies of pyproject.toml that bring them.
OPTIONAL = {"matplotlib": "plot", "plotly": "page", "tqdm": "progress", "h5py": "data", "xarray": "data", "pandas": "data",
            "scipy": "study", "rainflow": "measure", "pyuff": "measure", "asammdf": "measure",
            "openpyxl": "table", "pythonfmu": "fmu"}


def extra(module: str) -> Any:
    """Import an optional package; where it is missing the message names the extra that brings it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0]
        if (error.name or "").partition(".")[0] != package:
            raise
        raise ModuleNotFoundError(f"this call needs {missing(package)}", name=package) from None


def missing(package: str) -> str:
    """What a message says of a package that is not there."""
    return f"{package}, which is {cure(package)}"


def cure(package: str) -> str:
    """How to get a package that is not there."""
    return f"not installed: pip install 'geartrain[{OPTIONAL[package]}]'"
