"""What can go wrong. Messages are the server's own words where it refused."""


class Error(Exception):
    """Any failure of Handgraft."""


class InvalidInput(Error, ValueError):
    """A file, a name or a number is wrong; the message names it and the permitted range."""


class WrongType(InvalidInput, TypeError):
    """An argument is of a type that it may not have."""


class Refused(Error):
    """The server refused. ``code`` is the kind: not_found, conflict, units, ..."""

    code: str = "internal"


class NotBegun(Error):
    """The hand that follows a demonstrator has no pose yet: send the next frame. Nothing was wrong with this one."""


class SolveFailed(Error):
    """The server could not solve what an edit asked for."""


class Cancelled(Error):
    """Somebody stopped the work."""


class TransportError(Error, ConnectionError):
    """The wire failed."""


class NoServer(TransportError):
    """No server answers; the message says on which domain and interface."""
