"""How a client reaches its daemon."""

from __future__ import annotations

import ipaddress
import os
import pathlib
from dataclasses import dataclass

import grpc

from collided.choices import check_text
from collided.errors import InvalidArgument
from collided.options import check_seconds

_LONGEST = 1e9  # seconds, of 30 years; far greater numbers overflow in gRPC, and count as none


@dataclass(frozen=True, kw_only=True)
class ConnectOptions:
    """TLS is used if tls_ca is set, else plain text. Files are in PEM format.

    token: bearer token; empty: none is sent.
    tls_ca: file with the certificates to trust. tls_certificate, tls_key: files of the client's own (mTLS).
    tls_server_name: name in the daemon's certificate, if it is not the address's.
    allow_insecure_token: send the token in plain text even to another host.
    patience: seconds to connect, also for each stream. deadline: seconds for one call, and for a stream's first answer. Both
        above 0, perhaps infinite.
    """

    token: str = ""
    tls_ca: str = ""
    tls_certificate: str = ""
    tls_key: str = ""
    tls_server_name: str = ""
    allow_insecure_token: bool = False
    patience: float = 5.0
    deadline: float = 60.0

    def __post_init__(self) -> None:
        check_text(self.token, "token")
        check_text(self.tls_server_name, "tls_server_name")
        for name in ("tls_ca", "tls_certificate", "tls_key"):
            file = getattr(self, name)
            check_text(os.fspath(file) if isinstance(file, os.PathLike) else file, name)
        for name in ("patience", "deadline"):
            seconds = getattr(self, name)
            check_seconds(seconds, name)
            if not seconds > 0:
                raise InvalidArgument(f"{name} is {seconds!r}; it must be above 0 seconds", field=name)
            object.__setattr__(self, name, float(min(seconds, _LONGEST)))

    def check(self, address: str) -> None:
        """Raises InvalidArgument for options that do not go together."""
        if not all("!" <= character <= "~" for character in self.token):
            raise InvalidArgument("token has a character that is not visible ASCII", field="token")
        if bool(self.tls_certificate) != bool(self.tls_key):
            raise InvalidArgument("tls_certificate and tls_key go together; only one is set", field="tls_key")
        if not self.tls_ca and (self.tls_certificate or self.tls_server_name):
            raise InvalidArgument("tls_ca is empty; tls_certificate and tls_server_name need it", field="tls_ca")
        if self.token and not (self.tls_ca or self.allow_insecure_token or is_local_address(address)):
            raise InvalidArgument(f"token is not sent to {address!r} in plain text; use TLS (tls_ca) or "
                                  "allow_insecure_token", field="token")

    def credentials(self) -> grpc.ChannelCredentials | None:
        """None for plain text."""
        if not self.tls_ca:
            return None
        own = {"private_key": _contents("tls_key", self.tls_key),
               "certificate_chain": _contents("tls_certificate", self.tls_certificate)} if self.tls_key else {}
        return grpc.ssl_channel_credentials(_contents("tls_ca", self.tls_ca), **own)


def _contents(option: str, name: str) -> bytes:
    try:
        text = pathlib.Path(name).read_bytes()
    except OSError as error:
        raise InvalidArgument(f"{option} is {name!r}, which cannot be read: {error.strerror}", field=option) from None
    if not text:
        raise InvalidArgument(f"{option} is {name!r}, which is empty", field=option)
    return text


def is_local_address(address: str) -> bool:
    """Whether it is a Unix socket, or a loopback address."""
    if address.startswith(("unix:", "unix-abstract:")):
        return True
    if "," in address:  # a list, whose others may be elsewhere
        return False
    for scheme in ("dns:", "ipv4:", "ipv6:"):
        if address.startswith(scheme):
            address = address.removeprefix(scheme).lstrip("/")
    host = address[1:].partition("]")[0] if address.startswith("[") else address
    if host.count(":") == 1:
        host = host.partition(":")[0]
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
