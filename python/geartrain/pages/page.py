"""Results as a page for a browser: one file, which needs no server and no network."""

from __future__ import annotations

import html
import os
import tempfile
import webbrowser
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from .._core.box import Box
from .._core.extras import extra
from ..errors import InputError, shown
from .page_pack import Block
from .page_results import ALONG, quantities, shown_results
from .page_study import shown_study

__all__ = ["Page", "page"]

#: The script of a page in its parts, in their order.
_SCRIPTS = ("tools", "response", "motion", "pictures", "views", "study", "begin")
#: Largest size of a page in bytes; beyond it waveforms and multipliers are kept of every second point, every fourth, ...
_LARGE, _SPARSE = 6_000_000, 64


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
        """Write the file: a page that is there is replaced once the new page is complete.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        InputError
            Where the path is none.
        OSError
        """
        with Box() as box:
            box.write_bytes(path, self.html.encode())

    def show(self) -> None:
        """Open it in the browser, from a temporary file."""
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="geartrain-", delete=False, encoding="utf-8") as file:
            file.write(self.html)
        webbrowser.open(Path(file.name).as_uri())


def page(
    results: Any, path: str | os.PathLike[str] | None = None, *, compare: Any = None, names: Sequence[str] = ("", ""),
    branches: Mapping[int, Any] | None = None,
) -> Page:
    """Results as a page for a browser, with the response curves, the motion at every point, tables and the train.

    Where it would be larger than 6 MB it has the waveforms and multipliers of every second point, or every fourth, and so on; it
    says so where another point is chosen.

    Parameters
    ----------
    results : Results, Branch or xarray.Dataset
        The Dataset of a `Study` becomes parallel coordinates and a scatter of its points.
    path : path-like, optional
        Where to write it.
    compare : Results or Branch, optional
        Laid over the first.
    names : (str, str)
        What the page calls the two; the titles of their trains unless told.
    branches : mapping of int to Branch, optional
        Of a study: whole results by the numbers of their points, as `Study.branch` gives them, which a click on the point opens.

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
    >>> gt.page(dataset, "study.html", branches={7: study.branch(7)})  # doctest: +SKIP
    """
    is_study = hasattr(results, "data_vars")
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        raise InputError(f"names = {shown(names)}: must be two names, of the results and of those laid over them")
    if is_study and compare is not None:
        raise InputError("compare: must be left out with the Dataset of a study")
    if not is_study and branches is not None:
        raise InputError("branches: must be left out but with the Dataset of a study")
    if is_study:
        pieces = [(f"branches[{point}]", f"point {point}", branch) for point, branch in (branches or {}).items()]
    else:
        pieces = [("results", names[0], results), ("compare", names[1], compare)][:1 if compare is None else 2]
    for what, _, piece in pieces:
        if not (hasattr(piece, "special_points") or hasattr(piece, "branches")):
            raise InputError(f"{what} = {shown(piece)}: must be gt.Results, a gt.Branch, or the Dataset of a study")
    extra("plotly.offline")
    places = {point: place for place, point in enumerate(branches or ())}
    every = 1
    while True:
        block = Block()
        told: dict[str, Any] = {"version": _version()}
        told["files"] = [shown_results(piece, name, block, every) for _, name, piece in pieces]
        told["along"] = ALONG
        told["quantities"] = quantities(*(file[name] for file in told["files"][:1] for name in ("forceWords", "forceUnit")))
        over = [file["over"] or "frequency" for file in told["files"]]
        if compare is not None and len({*over}) > 1:
            raise InputError(f"compare: goes over {over[1]}: must go over {over[0]}, as the results do")
        told["study"] = shown_study(results, block, places) if is_study else None
        found = Page(_filled((told["study"] or told["files"][0])["title"] or "Gear train", block.packed(told)))
        if len(found.html) < _LARGE or every >= _SPARSE:
            break
        every *= 2
    if path is not None:
        found.write(path)
    return found


def _filled(title: str, data: str) -> str:
    """The page with its parts in their places."""
    parts = {
        "title": html.escape(f"{title} - geartrain"),
        "style": _part("page.css"),
        "script": "\n".join(_part(f"{name}.js") for name in _SCRIPTS),
        "plotly": _library(),
        "data": data,
    }
    text = _part("page.html")
    for name, part in parts.items():
        text = text.replace(f"<!--{name}-->", part)
    return text


@cache
def _library() -> str:
    """The script of plotly, compressed."""
    return Block().packed(extra("plotly.offline").get_plotlyjs())


def _part(name: str) -> str:
    """A file of the folder ``page_parts``."""
    return files(__package__).joinpath("page_parts", name).read_text(encoding="utf-8")


def _version() -> str:
    with Box() as box:
        return box.text("version")
