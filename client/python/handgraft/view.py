"""A session as a page: in a notebook's frame, in a browser, or as one file."""

from __future__ import annotations

import html
import os
import pathlib

from .errors import InvalidInput

_STYLE = "border: 1px solid #8884; border-radius: 8px"


class View:
    """What `Session.view` returns: notebooks show it, `str` is its address or its text."""

    def __init__(self, address: str | None, text: str | None, title: str, width: int | str, height: int | str):
        #: Of the live page; None for a picture that is kept.
        self.address = address
        #: The page as one HTML file; None for a live one.
        self.html = text
        self._title = title
        self._size = (width, height)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page as one file that opens without a server or a network."""
        if self.html is None:
            raise InvalidInput("a live view is no file; view(live=False) is")
        pathlib.Path(path).write_text(self.html, encoding="utf-8")

    def _repr_html_(self) -> str:
        width, height = (html.escape(str(size), quote=True) for size in self._size)
        name, source = ("src", self.address) if self.html is None else ("srcdoc", self.html)
        return (f'<iframe title="{html.escape(self._title, quote=True)}" width="{width}" height="{height}" '
                f'style="{_STYLE}" allow="clipboard-write" {name}="{html.escape(source or "", quote=True)}"></iframe>')

    def __str__(self) -> str:
        return self.address or self.html or ""

    def __repr__(self) -> str:
        return f"View({self._title!r}, {self.address or 'as one file'})"


def web_folder() -> str:
    """Where the page lies: share/handgraft/web of the prefix, or of the build, that holds this module.

    Raises InvalidInput where it was not built.
    """
    here = pathlib.Path(__file__).resolve()
    for folder in here.parents:
        page = folder / "share" / "handgraft" / "web"
        if (page / "index.html").is_file():
            return str(page)
    raise InvalidInput(f"there is no page in share/handgraft/web above {here.parent}: Debian's package handgraft brings it, "
                       "and a build where nodejs and npm are installed")
