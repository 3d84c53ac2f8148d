#!/usr/bin/env python3
"""How often a gRPC client may ping: as often as GetServerInfo says, and a client that pings much more often is dropped."""

import pathlib
import socket
import sys
import threading
import time
import unittest

sys.path[:0] = [str(pathlib.Path(sys.argv[3]) / "tests" / "client" / "python")]
import grpc
from support import DAEMON, Daemon, main

import collided
from collided.v1 import collision_service_pb2 as api
from collided.v1 import collision_service_pb2_grpc

TRIANGLE = collided.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def frame(kind, payload):
    """A frame of HTTP/2 on stream 0, without flags."""
    return len(payload).to_bytes(3, "big") + bytes([kind, 0]) + bytes(4) + payload


class Pinging:
    """A client that watches a scene in which nothing happens, and pings every so many seconds."""

    def __init__(self, address, scene_id, seconds):
        self.channel = grpc.insecure_channel(address, [
            ("grpc.keepalive_time_ms", round(seconds * 1000)), ("grpc.keepalive_permit_without_calls", 1),
            ("grpc.http2.max_pings_without_data", 0), ("grpc.use_local_subchannel_pool", 1)])
        stub = collision_service_pb2_grpc.CollisionServiceStub(self.channel)
        self.limits = stub.GetServerInfo(api.GetServerInfoRequest()).limits
        self.end = None
        watch = stub.WatchScene(api.WatchSceneRequest(scene_id=scene_id))
        self.thread = threading.Thread(target=self.watch, args=(watch,))
        self.thread.start()

    def watch(self, watch):
        try:
            for _ in watch:
                pass
        except grpc.RpcError as error:
            self.end = error

    def close(self):
        self.channel.close()
        self.thread.join()


class Pings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(str(DAEMON))
        cls.addClassCleanup(cls.daemon.kill)

    def test_a_client_may_ping_as_often_as_it_is_told(self):
        with collided.Session({"mesh": TRIANGLE}, server=self.daemon.address) as session:
            clients = [Pinging(self.daemon.address, session.scene.id, seconds) for seconds in (1, 0.1)]
            time.sleep(5)  # of a ping a second, the fourth was one too many
            self.assertEqual([client.end for client in clients], [None, None])
            self.assertEqual(clients[0].limits.min_ping_seconds, 0.1)
            for client in clients:
                client.close()

    def test_one_that_pings_without_pause_is_dropped(self):
        settings, ping = frame(4, b""), frame(6, bytes(8))
        with socket.socket(socket.AF_UNIX) as peer:
            peer.connect(self.daemon.address.removeprefix("unix:"))
            peer.settimeout(10)
            peer.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + settings + 20 * ping)
            received = b""
            while chunk := peer.recv(4096):
                received += chunk
        self.assertIn(b"too_many_pings", received)


if __name__ == "__main__":
    main()
