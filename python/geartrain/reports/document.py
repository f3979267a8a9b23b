"""A document of headings, sentences, tables and pictures, as PDF or as one file of HTML."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from .._core.extras import extra

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Document"]

#: A4 in inches; margin; height of a line of text, and letters of its fixed width in a line.
_PAGE, _MARGIN, _LINE, _LETTERS = (8.27, 11.69), 0.7, 0.155, 100
_HEAD = 0.34
#: Height of a line of fixed width, and letters in it.
_LOW, _FIXED = 0.124, 118
#: Largest and usual height of a picture on a page [inches].
_TALLEST, _USUAL = 8.5, 5.2

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 1px solid #bbb; }
table { border-collapse: collapse; margin: 0.8rem 0; } td, th { padding: 0.15rem 0.7rem; border-bottom: 1px solid #ddd; }
th { text-align: left; } td { text-align: right; } td:first-child { text-align: left; }
pre { font-size: 12px; line-height: 1.35; overflow-x: auto; background: #f6f6f6; padding: 0.7rem; } img { max-width: 100%; }
"""


@dataclass
class Document:
    """A document in the making.

    Attributes
    ----------
    title : str
    blocks : list
        Kind and content, in their order.
    """

    title: str
    blocks: list[tuple[str, Any]] = field(default_factory=list)

    def heading(self, text: str) -> None:
        self.blocks.append(("heading", text))

    def sentence(self, text: str) -> None:
        self.blocks.append(("sentence", text))

    def listed(self, items: Sequence[str]) -> None:
        self.blocks.append(("list", list(items)))

    def printed(self, text: str) -> None:
        """Text of fixed width, as it is printed."""
        self.blocks.append(("printed", text.rstrip("\n")))

    def table(self, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        self.blocks.append(("table", [list(head), *(list(row) for row in rows)]))

    def picture(self, figure: Figure, about: str) -> None:
        self.blocks.append(("picture", (figure, about)))

    def html(self) -> str:
        """The document as one file that needs no other."""
        parts = [f"<h1>{html.escape(self.title)}</h1>"]
        for kind, content in self.blocks:
            if kind == "heading":
                parts.append(f"<h2>{html.escape(content)}</h2>")
            elif kind == "sentence":
                parts.append(f"<p>{html.escape(content)}</p>")
            elif kind == "list":
                parts.append("<ul>" + "".join(f"<li>{html.escape(item)}</li>" for item in content) + "</ul>")
            elif kind == "printed":
                parts.append(f"<pre>{html.escape(content)}</pre>")
            elif kind == "table":
                rows = ["<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"
                        for row, tag in zip(content, ["th", *["td"] * len(content)])]
                parts.append(f"<table>{''.join(rows)}</table>")
            else:
                figure, about = content
                stream = io.BytesIO()
                figure.savefig(stream, format="png", dpi=150, bbox_inches="tight")
                data = base64.b64encode(stream.getvalue()).decode()
                parts.append(f'<p><img alt="{html.escape(about)}" src="data:image/png;base64,{data}"></p>')
        head = f'<meta charset="utf-8"><title>{html.escape(self.title)} - geartrain</title><style>{_STYLE}</style>'
        return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(parts) + "\n</body></html>\n"

    def pdf(self) -> bytes:
        """The document as PDF; needs matplotlib."""
        pages = extra("matplotlib.backends.backend_pdf")
        stream = io.BytesIO()
        about = {"Title": self.title, "Creator": "geartrain", "CreationDate": None}
        with pages.PdfPages(stream, metadata=about) as file:
            sheet = _Sheet(file)
            sheet.line(self.title, size=16, bold=True, height=0.45)
            kinds = [kind for kind, _ in self.blocks]
            for (kind, content), after in zip(self.blocks, [*kinds[1:], ""]):
                if kind == "heading":
                    sheet.need(_HEAD + (_USUAL if after == "picture" else 4 * _LINE))
                    sheet.skip(0.12)
                    sheet.line(content, size=12, bold=True, height=_HEAD)
                elif kind == "sentence":
                    sheet.text(content)
                elif kind == "list":
                    for item in content:
                        sheet.text(f"- {item}", indent="  ")
                elif kind == "printed":
                    sheet.fixed(content.splitlines())
                elif kind == "table":
                    sheet.fixed(_columns(content))
                else:
                    sheet.picture(content[0])
            sheet.close()
        return stream.getvalue()


def _columns(rows: list[list[str]]) -> list[str]:
    """A table as lines of fixed width: the first column at the left, the others at the right."""
    wide = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(size) if place == 0 else cell.rjust(size) for place, (cell, size) in enumerate(zip(row, wide)))
             for row in rows]
    return [lines[0], "-" * len(lines[0]), *lines[1:]]


class _Sheet:
    """Pages of a PDF, filled from above."""

    def __init__(self, file: Any) -> None:
        self.file = file
        self.figure_of = extra("matplotlib.figure").Figure
        self.page: Any = None
        self.left = 0.0
        self.number = 0

    def need(self, height: float) -> None:
        """Begin a page where the rest of this one is too low."""
        if self.page is None or self.left < height:
            self.close()
            self.page, self.left = self.figure_of(figsize=_PAGE), _PAGE[1] - 2 * _MARGIN
            self.number += 1
            self.page.text(0.5, 0.4 / _PAGE[1], str(self.number), ha="center", fontsize=8)

    def close(self) -> None:
        if self.page is not None:
            self.file.savefig(self.page)
        self.page = None

    def skip(self, height: float) -> None:
        self.left -= height

    def line(self, text: str, size: float = 9, bold: bool = False, height: float = _LINE, family: str = "sans-serif") -> None:
        self.need(height)
        # A dollar sign begins mathematics.
        self.page.text(_MARGIN / _PAGE[0], (_MARGIN + self.left) / _PAGE[1], text.replace("$", r"\$"), fontsize=size, va="top",
                       fontweight="bold" if bold else "normal", family=family, linespacing=1.187)
        self.left -= height

    def text(self, text: str, indent: str = "") -> None:
        for line in wrap(text, _LETTERS, subsequent_indent=indent) or [""]:
            self.line(line, height=1.15 * _LINE)
        self.skip(0.05)

    def fixed(self, lines: Sequence[str]) -> None:
        """Lines of fixed width, broken where they are too long, and gathered: a text of matplotlib takes a millisecond."""
        rest = [part.rstrip() for line in lines
                for part in wrap(line, _FIXED, subsequent_indent="    ", replace_whitespace=False, drop_whitespace=False) or [""]]
        while rest:
            self.need(min(len(rest), 3) * _LOW)
            count = max(1, int(self.left / _LOW))
            self.line("\n".join(rest[:count]), size=7, family="monospace", height=len(rest[:count]) * _LOW)
            rest = rest[count:]
        self.skip(_LINE)

    def picture(self, figure: Figure) -> None:
        """A picture over the width of the page, or as large as its height allows."""
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=150, bbox_inches="tight")
        stream.seek(0)
        image = extra("matplotlib.image").imread(stream)
        wide = min(_PAGE[0] - 2 * _MARGIN, _TALLEST * image.shape[1] / image.shape[0])
        high = wide * image.shape[0] / image.shape[1]
        self.need(high)
        axes = self.page.add_axes((_MARGIN / _PAGE[0], (_MARGIN + self.left - high) / _PAGE[1], wide / _PAGE[0], high / _PAGE[1]))
        axes.imshow(image, interpolation="none", aspect="auto")
        axes.axis("off")
        self.left -= high + 0.1
