"""A daemon's address that passes everything on to a daemon, and notes it."""

import array
import mmap
import os
import socket
import tempfile
import threading
from concurrent import futures

import grpc

from conversation import LOCAL, pack, shared_ranges

CARRIED = ("scene-id",)  # metadata that matters
PACKET = 64 << 10
DETAILS = "grpc-status-details-bin"
INFO = "/collided.v1.CollisionService/GetServerInfo"


def refused_field(messages, metadata):
    """The field that a status names, by its details."""
    for key, value in metadata or ():
        if key == DETAILS:
            for detail in messages["collided.v1.RpcStatus"].FromString(value).details:
                if detail.type_url.endswith("/google.rpc.BadRequest"):
                    return messages["collided.v1.BadRequest"].FromString(detail.value).field_violations[0].field
    return ""


class Recorder(grpc.GenericRpcHandler):
    """Serves at `address` until it is closed."""

    def __init__(self, daemon, daemon_local, messages):
        self._folder = tempfile.TemporaryDirectory()
        self.address = f"unix:{self._folder.name}/socket"
        self._messages, self._daemon_local, self._local = messages, daemon_local, f"{self._folder.name}/local"
        self._lock, self._events, self._calls = threading.Lock(), [], 0
        unlimited = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]
        self._channel = grpc.insecure_channel(daemon, unlimited)
        self._server = grpc.server(futures.ThreadPoolExecutor(32), handlers=[self], options=unlimited)
        self._server.add_insecure_port(self.address)
        self._server.start()
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.bind(self._local)
        self._listener.listen()
        threading.Thread(target=self._accept, daemon=True).start()

    def take(self):
        """The events so far, calls numbered anew in the next ones."""
        with self._lock:
            events, self._events, self._calls = self._events, [], 0
        return events

    def close(self):
        self._server.stop(0).wait()
        self._channel.close()
        self._listener.close()
        self._folder.cleanup()

    def _begin(self, method, **more):
        with self._lock:
            call, self._calls = self._calls, self._calls + 1
            self._events.append({"call": call, "begin": method, **more})
        return call

    def _note(self, call, **event):
        with self._lock:
            self._events.append({"call": call, **event})

    # gRPC.

    def service(self, handler_call_details):
        method = handler_call_details.method
        return grpc.stream_stream_rpc_method_handler(lambda requests, context: self._pass_on(method, requests, context))

    def _pass_on(self, method, requests, context):
        metadata = [(k, v) for k, v in context.invocation_metadata() if k in CARRIED]
        call = self._begin(method, metadata=dict(metadata))

        def noted():
            for request in requests:
                self._note(call, send=pack(request))
                yield request
            self._note(call, half_close=True)

        answers = self._channel.stream_stream(method)(noted(), metadata=metadata)
        context.add_callback(answers.cancel)
        try:
            for answer in answers:
                self._note(call, receive=pack(answer))
                yield self._with_own_socket(answer) if method == INFO else answer
            code, details, trailing = grpc.StatusCode.OK, "", ()
        except grpc.RpcError as error:
            code, details, trailing = error.code(), error.details(), error.trailing_metadata() or ()
        if code is grpc.StatusCode.CANCELLED:
            self._note(call, cancel=True)
        else:
            self._note(call, end=code.value[0], field=refused_field(self._messages, trailing))
        context.set_trailing_metadata([(k, v) for k, v in trailing if k == DETAILS])
        context.set_code(code)
        context.set_details(details)

    def _with_own_socket(self, answer):
        info = self._messages["collided.v1.GetServerInfoResponse"].FromString(answer)
        info.local_socket = self._local
        return info.SerializeToString()

    # The local socket.

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            daemon = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            daemon.connect(self._daemon_local)
            LocalCall(self, client, daemon).start()


class LocalCall:
    """A connection to the local socket."""

    def __init__(self, recorder, client, daemon):
        self._recorder, self._client, self._daemon = recorder, client, daemon
        self._call = recorder._begin(LOCAL)
        self._requests, self._answers = recorder._messages.of_call(LOCAL)
        self._memory, self._input = b"", 0

    def start(self):
        for target in (self._forward, self._backward):
            threading.Thread(target=target, daemon=True).start()

    def _bytes_of(self, ranges, base):
        return [[r.offset, pack(self._memory[base + r.offset:base + r.offset + r.size])] for r in ranges]

    def _forward(self):
        while True:
            packet, files, _, _ = socket.recv_fds(self._client, PACKET, 1)
            if not packet:
                self._recorder._note(self._call, half_close=True)
                try:
                    self._daemon.shutdown(socket.SHUT_WR)
                except OSError:
                    pass
                return
            request = self._requests.FromString(packet)
            if request.HasField("open"):
                self._input = request.open.input_bytes
            if files:
                self._memory = mmap.mmap(files[0], os.fstat(files[0]).st_size)
            memory = self._bytes_of(shared_ranges(request), 0)
            if request.HasField("shared_frame"):
                start = request.shared_frame.offset
                frame = self._memory[start:start + request.shared_frame.size]
                memory += self._bytes_of(shared_ranges(self._recorder._messages["collided.v1.Frame"].FromString(frame)), 0)
            self._recorder._note(self._call, send=pack(packet), memory=memory)
            self._daemon.sendmsg([packet], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", files))] if files else [])
            for file in files:
                os.close(file)

    def _backward(self):
        while True:
            try:
                packet = self._daemon.recv(PACKET)
            except OSError:
                packet = b""
            if not packet:
                break
            memory = self._bytes_of(shared_ranges(self._answers.FromString(packet)), self._input)
            self._recorder._note(self._call, receive=pack(packet), memory=memory)
            try:
                self._client.send(packet)
            except OSError:  # a client that leaves does not read the end
                break
        self._recorder._note(self._call, end=0, field="")
        self._client.close()
