"""Sends the requests of a recording to a daemon, and compares the answers."""

import array
import fcntl
import mmap
import os
import queue
import socket

import grpc

from conversation import LOCAL, is_message, is_repeated, shared_ranges, unpack
from differences import differences
from recorder import PACKET, refused_field

SECONDS = 30
# Fields of answers that hold ids and tokens, and fields of requests that repeat them.
CHOSEN = {"collided.v1.Scene.scene_id", "collided.v1.Scene.resume_token", "collided.v1.ListScenesResponse.next_page_token"}
REPEATED = {"scene_id", "resume_token", "page_token"}


class Names:
    """Maps ids and tokens of the recording to those that the daemon has chosen now."""

    def __init__(self):
        self._now = {}

    def learn(self, recorded, answered):
        for field, was in recorded.ListFields():
            if is_message(field):
                now = getattr(answered, field.name)
                for a, b in zip(was, now) if is_repeated(field) else ((was, now),):
                    self.learn(a, b)
            elif field.full_name in CHOSEN:
                self._now[was] = getattr(answered, field.name)

    def of(self, recorded):
        return self._now.get(recorded, recorded)

    def put_into(self, request):
        """True if something was substituted."""
        changed = False
        for field, value in request.ListFields():
            if is_message(field):
                for each in value if is_repeated(field) else (value,):
                    changed |= self.put_into(each)
            elif field.name in REPEATED and value in self._now:
                setattr(request, field.name, self._now[value])
                changed = True
        return changed


class GrpcCall:
    def __init__(self, replay, event):
        self._replay, self._requests = replay, queue.SimpleQueue()
        metadata = [(key, replay.names.of(value)) for key, value in event["metadata"].items()]
        self._answers = replay.channel.stream_stream(event["begin"])(iter(self._requests.get, None), metadata=metadata, timeout=SECONDS)

    def send(self, message, memory):
        self._requests.put(message)

    def half_close(self):
        self._requests.put(None)

    def receive(self):
        """The next answer, with nothing in shared memory; None at the end."""
        try:
            return next(self._answers, None), []
        except grpc.RpcError:
            return None, []

    def end(self):
        """The code, and the field that is refused."""
        return self._answers.code().value[0], refused_field(self._replay.messages, self._answers.trailing_metadata())

    def close(self):
        self._requests.put(None)
        self._answers.cancel()


class LocalCall:
    def __init__(self, replay, event):
        self._requests, self._answers = replay.messages.of_call(LOCAL)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.settimeout(SECONDS)
        self._socket.connect(replay.local)
        self._memory, self._input = b"", 0

    def send(self, message, memory):
        request, files = self._requests.FromString(message), []
        if request.HasField("open"):
            self._input = request.open.input_bytes
            size = self._input + request.open.output_bytes
            if size:
                files = [os.memfd_create("replay", os.MFD_ALLOW_SEALING)]
                os.ftruncate(files[0], size)
                fcntl.fcntl(files[0], fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
                self._memory = mmap.mmap(files[0], size)
        for offset, data in memory:
            data = unpack(data)
            self._memory[offset:offset + len(data)] = data
        self._socket.sendmsg([message], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", files))] if files else [])
        for file in files:
            os.close(file)

    def half_close(self):
        self._socket.shutdown(socket.SHUT_WR)

    def receive(self):
        packet = self._socket.recv(PACKET)
        if not packet:
            return None, []
        ranges = shared_ranges(self._answers.FromString(packet))
        return packet, [self._memory[self._input + r.offset:self._input + r.offset + r.size] for r in ranges]

    def end(self):
        return 0, ""

    def close(self):
        self._socket.close()


class Replay:
    """A recording, on a daemon with these addresses."""

    def __init__(self, messages, address, local):
        self.messages, self.local, self.names = messages, local, Names()
        unlimited = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]
        self.channel = grpc.insecure_channel(address, unlimited)
        self._calls = {}

    def run(self, events):
        """Returns what differs from the recording, in words."""
        found, methods = [], {}
        for number, event in enumerate(events, 1):
            call = event["call"]
            if "begin" in event:
                methods[call] = event["begin"]
                self._calls[call] = (LocalCall if event["begin"] == LOCAL else GrpcCall)(self, event)
                continue
            method = methods[call].rpartition("/")[2]
            found += [f"event {number}, {method}: {what}" for what in self._step(methods[call], self._calls[call], event)]
            if found and "receive" in event:
                break  # what follows may wait for ever
        for call in self._calls.values():
            call.close()
        self.channel.close()
        return found

    def _step(self, method, call, event):
        asks, answers = self.messages.of_call(method)
        if "send" in event:
            message = unpack(event["send"])
            request = asks.FromString(message)
            call.send(request.SerializeToString() if self.names.put_into(request) else message, event.get("memory", ()))
        elif "half_close" in event:
            call.half_close()
        elif "cancel" in event:
            call.close()
        elif "receive" in event:
            yield from self._compare(answers, call, event)
        else:
            was, now = (event["end"], event["field"]), call.end()
            if was != now:
                yield f"ended with code {now[0]} ({now[1] or 'no field'}), was code {was[0]} ({was[1] or 'no field'})"

    def _compare(self, answers, call, event):
        message, memory = call.receive()
        if message is None:
            yield "no answer, where there was one"
            return
        recorded, answered = answers.FromString(unpack(event["receive"])), answers.FromString(message)
        self.names.learn(recorded, answered)
        yield from differences(recorded, answered)
        was = [unpack(data) for _, data in event.get("memory", ())]
        if was != memory:
            yield "arrays in shared memory differ"
