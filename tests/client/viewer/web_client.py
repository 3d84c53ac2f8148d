"""A browser as collidectl view sees it, and what no browser would send: HTTP and WebSockets (RFC 6455) over bare sockets."""

import base64
import json
import os
import socket
import struct
import urllib.parse

TIMEOUT = 60
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
KINDS = {1: "scene", 2: "frame", 3: "status"}


def connect(url):
    parts = urllib.parse.urlsplit(url)
    return socket.create_connection((parts.hostname, parts.port), TIMEOUT)


def request(url, method="GET", path=None, **headers):
    """Status, headers (with lower-case names) and body. Underscores in the names of headers stand for dashes."""
    parts = urllib.parse.urlsplit(url)
    lines = {"Host": parts.netloc, **{name.replace("_", "-"): value for name, value in headers.items()}}
    text = f"{method} {path or parts.path} HTTP/1.1\r\n" + "".join(f"{name}: {value}\r\n" for name, value in lines.items())
    with connect(url) as peer:
        peer.sendall((text + "\r\n").encode("latin-1"))
        return parse(read_all(peer))


def read_all(peer):
    """Until the other side closes."""
    read = b""
    try:
        while part := peer.recv(1 << 16):
            read += part
    except ConnectionResetError:
        pass
    return read


def parse(answer):
    head, _, body = answer.partition(b"\r\n\r\n")
    status, *fields = head.decode("latin-1").split("\r\n")
    return int(status.split()[1]), {name.lower(): value for name, _, value in (field.partition(": ") for field in fields)}, body


def decode(message):
    """A message of messages.hpp: its JSON, with its kind and its arrays as tuples."""
    kind, json_bytes = struct.unpack_from("<II", message)
    assert json_bytes % 4 == 0
    out, at = json.loads(message[8:8 + json_bytes]), 8 + json_bytes
    for name, length in out.pop("arrays").items():
        out[name] = struct.unpack_from(f"<{length}{'f' if name == 'positions' else 'I'}", message, at)
        at += 4 * length
    assert at == len(message), (at, len(message))
    return {**out, "kind": KINDS[kind]}


class Closed(Exception):
    """The server ended the connection; `code` is that of its close frame, if it sent one."""

    def __init__(self, code=None):
        super().__init__(f"closed with {code}")
        self.code = code


class WebSocket:
    """Takes what is shown. Raises ConnectionRefusedError, with the status, if the server answers otherwise."""

    def __init__(self, url, **headers):
        parts = urllib.parse.urlsplit(url)
        headers = {"Host": parts.netloc, "Origin": f"http://{parts.netloc}", **headers}
        fields = "".join(f"{name}: {value}\r\n" for name, value in headers.items() if value is not None)
        self.peer = connect(url)
        self.peer.sendall((f"GET {parts.path}frames HTTP/1.1\r\n{fields}Upgrade: websocket\r\nConnection: Upgrade\r\n"
                           f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}\r\n\r\n")
                          .encode("latin-1"))
        self.unread = b""
        while b"\r\n\r\n" not in self.unread:
            self.unread += self.peer.recv(1 << 16) or b"HTTP/1.1 0\r\n\r\n"
        head, _, self.unread = self.unread.partition(b"\r\n\r\n")
        status = int(head.split()[1])
        if status != 101:
            self.peer.close()
            raise ConnectionRefusedError(status)

    def close(self):
        self.peer.close()

    def _take(self, size):
        while len(self.unread) < size:
            part = self.peer.recv(1 << 16)
            if not part:
                raise Closed
            self.unread += part
        taken, self.unread = self.unread[:size], self.unread[size:]
        return taken

    def send(self, payload, opcode=TEXT, is_last=True, length=None):
        """`length`: that the frame claims to have."""
        length = len(payload) if length is None else length
        head = bytes([0x80 * is_last | opcode])
        head += bytes([0x80 | length]) if length < 126 else b"\xfe" + struct.pack(">H", length) if length < 1 << 16 \
            else b"\xff" + struct.pack(">Q", length)
        self.peer.sendall(head + bytes(4) + payload)  # masked with zeros

    def ask(self):
        self.send(b"next")

    def receive(self, timeout=TIMEOUT):
        """The next message, decoded. Raises TimeoutError, Closed."""
        self.peer.settimeout(timeout)
        message = b""
        while True:
            first, second = self._take(2)
            length = second & 0x7F
            if length >= 126:
                length = struct.unpack(">H", self._take(2))[0] if length == 126 else struct.unpack(">Q", self._take(8))[0]
            payload, opcode = self._take(length), first & 0x0F
            if opcode == CLOSE:
                raise Closed(struct.unpack(">H", payload[:2])[0])
            if opcode == PING:
                self.send(payload, PONG)
            elif opcode != PONG:
                message += payload
                if first & 0x80:
                    return decode(message)

    def until(self, kind, is_wanted=lambda message: True):
        """The next message of a kind that is wanted. Frames are asked for."""
        while True:
            message = self.receive()
            if message["kind"] == "frame":
                self.ask()
            if message["kind"] == kind and is_wanted(message):
                return message

    def until_closed(self):
        try:
            while True:
                self.receive()
        except Closed as closed:
            return closed.code
        except ConnectionResetError:
            return None
