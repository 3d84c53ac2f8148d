"""Peers of the local socket: packets that are cut off, files by the hundred, memory that goes away."""

import contextlib
import fcntl
import os
import socket

import grpc

from collided.v1 import local_pb2

from attacks.calls import Caller
from attacks.catalogue import attack, hold
from attacks.tip import tip_frame

PAGES = 1 << 16
NAMES = {code.value[0]: code.name for code in grpc.StatusCode}


def opening(target, scene="none", size=PAGES):
    packet = local_pb2.LocalRequest()
    packet.open.version, packet.open.token, packet.open.input_bytes = 1, target.token, size
    packet.open.open.scene_id = scene
    return packet.SerializeToString()


def memfd(size=PAGES, sealed=False):
    file = os.memfd_create("hostile", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    os.ftruncate(file, size)
    if sealed:
        fcntl.fcntl(file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK)
    return file


def answer(connection, told):
    data = connection.recv(1 << 16)
    packet = local_pb2.LocalResponse.FromString(data)
    told["packets"] += 1
    closed = packet.HasField("closed")
    told.met[NAMES[packet.closed.code] if closed else "answered" if data else "ended"] += 1
    return packet


@attack("local socket")
def local_silence(target, told, over):
    """Connections that say nothing."""
    hold([target.local() for _ in range(100)], told, over)


@attack("local socket")
def descriptor_flood(target, told, over):
    """Packets with two hundred files each."""
    with contextlib.closing(target.local()) as connection, open(os.devnull, "rb") as null:
        told["files"] += 200
        socket.send_fds(connection, [b"\xff"], [null.fileno()] * 200)
        answer(connection, told)


@attack("local socket")
def cut_off_packets(target, told, over):
    """Openings that end in the middle."""
    whole = opening(target)
    for size in range(1, len(whole), 7):
        with contextlib.closing(target.local()) as connection:
            connection.send(whole[:size])
            answer(connection, told)


@attack("local socket")
def memory_that_shrinks(target, told, over):
    """Memory without a seal, and memory that is shrunk once the daemon has it (a trap by SIGBUS)."""
    with Caller(target) as caller:
        scene = caller.create().scene_id
        for sealed in (False, True):
            with contextlib.closing(target.local()) as connection:
                file = memfd(sealed=sealed)
                socket.send_fds(connection, [opening(target, scene)], [file])
                try:
                    os.ftruncate(file, 0)
                except PermissionError:
                    told.met["seal held"] += 1
                os.close(file)
                answer(connection, told)
                send_shared(connection, told, 0, 36)


@attack("local socket")
def ranges_that_lie(target, told, over):
    """Positions that are said to lie where there is no memory."""
    with Caller(target) as caller, contextlib.closing(target.local()) as connection:
        scene, file = caller.create().scene_id, memfd(sealed=True)
        socket.send_fds(connection, [opening(target, scene)], [file])
        os.close(file)
        answer(connection, told)
        for offset, size in ((PAGES, 36), (2**64 - 36, 36), (PAGES - 12, 36), (0, 2**63)):
            send_shared(connection, told, offset, size)


def send_shared(connection, told, offset, size):
    packet = local_pb2.LocalRequest(frame=tip_frame(send_shared.next_id, 2))
    send_shared.next_id += 1
    for update in packet.frame.updates:
        update.ClearField("positions")
        update.shared_positions.offset, update.shared_positions.size = offset, size
    try:
        connection.send(packet.SerializeToString())
        answer(connection, told)
    except OSError as error:
        told.of(error)


send_shared.next_id = 1
