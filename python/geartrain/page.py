"""Results as a page for a browser: one file, which needs no server and no network."""

from __future__ import annotations

import html
import os
import tempfile
import webbrowser
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from ._box import Box
from ._extras import extra
from ._page_pack import Block
from ._page_results import quantities, shown_results
from .errors import InputError, shown

__all__ = ["Page", "page"]


class Page:
    """Results as one file of HTML with everything in it, which any browser of 2023 or later opens without a network.

    Attributes
    ----------
    html : str
        The whole file.
    """

    def __init__(self, html: str) -> None:
        self.html = html

    def __repr__(self) -> str:
        return f"<Page of {len(self.html.encode()) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        """In a notebook: the page in a frame of its own."""
        return f'<iframe srcdoc="{html.escape(self.html)}" style="width:100%;height:900px;border:0" title="geartrain"></iframe>'

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        OSError
        """
        Path(path).write_text(self.html, encoding="utf-8")

    def show(self) -> None:
        """Open it in the browser, from a temporary file."""
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="geartrain-", delete=False, encoding="utf-8") as file:
            file.write(self.html)
        webbrowser.open(Path(file.name).as_uri())


def page(
    results: Any, path: str | os.PathLike[str] | None = None, *, compare: Any = None, names: Sequence[str] = ("", ""),
) -> Page:
    """Results as a page for a browser, with the response curves, the motion at every point, tables and the train.

    Parameters
    ----------
    results : Results or Branch
    path : path-like, optional
        Where to write it.
    compare : Results or Branch, optional
        Laid over the first.
    names : (str, str)
        What the page calls the two; the titles of their trains unless told.

    Returns
    -------
    Page
        ``.show()`` opens it; in a notebook it is shown.

    Raises
    ------
    InputError
        Where there is nothing to show.
    ModuleNotFoundError
        Without plotly or matplotlib.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> page = gt.page(branch, "response.html")  # doctest: +SKIP
    >>> page.show()  # doctest: +SKIP
    """
    for what, value in (("results", results), *((("compare", compare),) if compare is not None else ())):
        if not (hasattr(value, "special_points") or hasattr(value, "response")):
            raise InputError(f"{what} = {shown(value)}: must be gt.Results or a gt.Branch")
    extra("plotly.offline")
    block = Block()
    both = [results] if compare is None else [results, compare]
    told = {
        "quantities": quantities(),
        "files": [shown_results(one, names[place], block) for place, one in enumerate(both)],
        "version": _version(),
    }
    found = Page(_filled(told["files"][0]["title"] or "Gear train", block.packed(told)))
    if path is not None:
        found.write(path)
    return found


def _filled(title: str, data: str) -> str:
    """The page with its parts in their places."""
    library = Block()
    parts = {
        "title": html.escape(f"{title} - geartrain"),
        "style": _part("page.css"),
        "script": _part("page.js"),
        "plotly": library.packed(extra("plotly.offline").get_plotlyjs()),
        "data": data,
    }
    text = _part("page.html")
    for name, part in parts.items():
        text = text.replace(f"<!--{name}-->", part)
    return text


def _part(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _version() -> str:
    with Box() as box:
        return box.text("version")
