"""What is explored, changed on the page: the address that follows, or what is wrong in a line."""

from __future__ import annotations

from base64 import b64decode
from binascii import Error as Base64Error
from typing import Any
from urllib.parse import urlencode

from dash import no_update

from propmap.errors import InputError
from propmap.explore.controls import of_query
from propmap.explore.given import MOST_BYTES, Shelf, read_upload
from propmap.explore.session import KNOWN, Session

OF_BLADE = ("chord-", "twist-")
"""How controls begin that mean nothing for another blade."""


class Choices:
    """Sessions by their addresses, and the addresses of changed ones.

    Parameters
    ----------
    first : Session
        That of the command line.
    shelf : Shelf
        Where files are.
    """

    def __init__(self, first: Session, shelf: Shelf) -> None:
        self.first, self.shelf = first, shelf

    def session(self, search: Any) -> Session:
        """What an address tells; ``InputError`` where it tells nonsense."""
        if search is not None and not isinstance(search, str):
            raise InputError("the address is damaged", "open / instead")
        return Session.of(of_query(search), self.first, self.shelf)

    def chosen(self, here: Any, prop: Any, law: Any, physics: Any) -> tuple[Any, str]:
        """The address of another propeller, constants or physics, or what is wrong."""
        try:
            session = self.session(here)
            if (prop, law, physics) == (session.name, session.law, session.physics):
                # The page has just been drawn.
                return no_update, ""
            query = {**of_query(here), **session.query()}
            if prop != session.name:
                for kind in ("fit", "geometry", "vehicle"):
                    query.pop(f"file-{kind}", None)
                # What follows from the blade is as usual for the new one.
                for name in ("rpm", "data"):
                    query.pop(name, None)
            if law != session.law:
                for kind in ("fit", "constants"):
                    query.pop(f"file-{kind}", None)
            query |= {
                "prop": str(prop or session.prop),
                "law": str(law or KNOWN),
                "physics": str(physics or ""),
            }
            for name in [name for name in query if name.startswith(OF_BLADE)]:
                del query[name]
            Session.of(query, self.first, self.shelf).model  # noqa: B018 - it may not exist
        except InputError as error:
            return no_update, str(error)
        return f"?{urlencode(query)}", ""

    def uploaded(self, here: Any, content: Any, name: Any) -> tuple[Any, str]:
        """The address with one more file, or what its reader says."""
        try:
            _, comma, body = str(content).partition(",")
            if not comma or len(body) > 1.4 * MOST_BYTES:
                raise InputError(
                    "the file is too large" if comma else "there is no file",
                    f"give one of at most {MOST_BYTES / 1e6:g} MB",
                    str(name)[-80:],
                )
            try:
                data = b64decode(body, validate=True)
            except (Base64Error, ValueError):
                raise InputError("the file came damaged", "give it again") from None
            given = read_upload(str(name), data)
            session = self.session(here).with_file(given, self.shelf.put(given))
            session.model  # noqa: B018 - it may not exist
            query = {k: v for k, v in of_query(here).items() if not k.startswith("file-")}
            if given.kind in ("geometry", "fit", "vehicle"):
                query.pop("rpm", None)
            if given.kind == "data":
                query["data"] = "file"
        except InputError as error:
            return no_update, str(error)
        return f"?{urlencode({**query, **session.query()})}", ""

    def removed(self, here: Any, kind: str) -> str:
        """The address without a file."""
        session = self.session(here)
        query = {**of_query(here), **session.query()}
        query.pop(f"file-{kind}", None)
        return f"?{urlencode(query)}"
