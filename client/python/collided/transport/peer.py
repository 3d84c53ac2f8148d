"""Who listens at the daemon's local socket, and whether a token may be sent there: anyone may listen at a path."""

from __future__ import annotations

import os
import pathlib
import socket
import stat
import struct
import sys
from dataclasses import dataclass

from collided.connection.options import ConnectOptions
from collided.errors import FailedPrecondition, InvalidArgument, PermissionDenied, Unavailable

NEEDS_LINUX = f"shared memory with a daemon needs Linux, and this is {sys.platform}"
_ROOT = 0
_SHORTEST, _LONGEST = 0.001, 1e6  # seconds of a socket's timeout; 0 would be none


@dataclass(frozen=True)
class LocalPeer:
    """The socket to connect to, and who may listen there: `daemon_user`, or whoever does at `address`."""

    path: str
    address: str
    daemon_user: int | None
    options: ConnectOptions


def connect_to_trusted(peer: LocalPeer) -> socket.socket:
    """A connection to the daemon's local socket. Raises Unavailable, or PermissionDenied for a user who is not trusted."""
    connection = connect_to_socket(peer.path, socket.SOCK_SEQPACKET, peer.options.patience)
    try:
        check_trusted(connection, peer.path, peer.address, peer.daemon_user, peer.options.patience)
    except Exception:
        connection.close()
        raise
    limit_sending(connection, peer.options.deadline)
    return connection


def limit_sending(connection: socket.socket, seconds: float) -> None:
    """Has connecting and sending, which wait for a listener that takes nothing, fail after so long."""
    timeout = min(max(seconds, _SHORTEST), _LONGEST)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(timeout), int(timeout % 1 * 1e6)))


def connect_to_socket(path: str, kind: socket.SocketKind, patience: float) -> socket.socket:
    """A connection to the Unix socket at `path`. Raises InvalidArgument if no socket can have it, else Unavailable."""
    if sys.platform != "linux":
        raise FailedPrecondition(NEEDS_LINUX, field="transport")
    connection = socket.socket(socket.AF_UNIX, kind)
    limit_sending(connection, patience)
    try:
        connection.connect(path)
    except (ValueError, OSError) as error:
        connection.close()
        if isinstance(error, BlockingIOError):
            raise Unavailable(f"no daemon answers at {path} within {patience:g} s (patience)") from None
        if isinstance(error, OSError) and error.errno:
            raise Unavailable(f"no daemon answers at {path}: {os.strerror(error.errno)}") from None
        raise InvalidArgument(f"local_socket is {path!r}, which is not a socket path") from None
    return connection


def user_at(connection: socket.socket) -> int:
    """The user who listens at the other end."""
    if sys.platform != "linux":
        raise FailedPrecondition(NEEDS_LINUX, field="transport")
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    return struct.unpack("iII", credentials)[1]


def check_trusted(connection: socket.socket, path: str, address: str, daemon_user: int | None, patience: float) -> None:
    """Raises PermissionDenied, naming what is wrong, unless a trusted user listens, and no one else can put a socket there.

    Trusted are this process's own user, root, `daemon_user`, and whoever listens at `address`, if that is a Unix socket:
    that user gets the token anyway.
    """
    if sys.platform != "linux":
        raise FailedPrecondition(NEEDS_LINUX, field="transport")
    users = {os.geteuid(), _ROOT} | ({daemon_user} if daemon_user is not None else set())
    owner = _folder_owner(path)
    listener = user_at(connection)
    if not {owner, listener} <= users:
        users |= _users_at(address, patience)
    known = ", ".join(map(str, sorted(users)))
    for user, what in ((listener, f"listens at the daemon's local socket {path}"),
                       (owner, f"owns the folder of the daemon's local socket {path}")):
        if user not in users:
            raise PermissionDenied(f"user {user} {what}; trusted are {known} (daemon_user)", field="daemon_user")


def _folder_owner(path: str) -> int:
    folder = pathlib.Path(path).absolute().parent
    try:
        about = folder.stat()
    except OSError as error:
        raise PermissionDenied(f"folder {folder} cannot be inspected: {error.strerror}", field="local") from None
    if about.st_mode & stat.S_IWOTH and not about.st_mode & stat.S_ISVTX:
        raise PermissionDenied(f"folder {folder} of the daemon's local socket can be written to by every user, and is not "
                               "sticky", field="local")
    return about.st_uid


def _users_at(address: str, patience: float) -> set[int]:
    if not address.startswith("unix:"):
        return set()
    path = address.removeprefix("unix:")
    try:
        with connect_to_socket(path.removeprefix("//"), socket.SOCK_STREAM, patience) as connection:
            return {user_at(connection)}
    except (InvalidArgument, Unavailable):  # an address that only gRPC understands adds no trusted user
        return set()
