"""A client of the daemon that the preferences name, or of one that Blender runs."""

import atexit
import pathlib

import bpy

from .package import collided
from .refused import Refused

_daemons = {}  # by program


def connect(preferences):
    """A client, to be closed. Raises Refused."""
    package = collided()
    options = {"token": _token(preferences)}
    for name in ("tls_ca", "tls_certificate", "tls_key"):
        options[name] = _path(getattr(preferences, name))
    daemon = None if preferences.server or not preferences.program else _daemon(package, _path(preferences.program))
    return package.Client(preferences.server or None, daemon=daemon, **options)


def stop_daemons():
    """Ends those that this add-on has started for a program of the preferences."""
    for daemon in _daemons.values():
        daemon.stop()
    _daemons.clear()


atexit.register(stop_daemons)


def _daemon(package, program):
    if not pathlib.Path(program).is_file():
        raise Refused(f"the daemon's program {program!r} is not a file (add-on preferences)")
    if program not in _daemons:
        _daemons[program] = package.OwnDaemon(program=program)
    return _daemons[program]


def _token(preferences):
    path = _path(preferences.token_file)
    if not path:
        return ""
    try:
        return pathlib.Path(path).read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(f"the token file cannot be read: {error}") from None


def _path(value):
    return bpy.path.abspath(value) if value else ""
