#!/usr/bin/env python3
"""Health and reflection of the daemon, used by clients that know only gRPC's own two services.

usage: health_reflection_test.py DAEMON STUBS_FOLDER
"""

import queue
import signal
import sys
import threading
import unittest

try:
    import grpc
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-protobuf)")
    sys.exit(77)

from daemon import Daemon

DAEMON, STUBS = sys.argv[1:3]
sys.path.insert(0, STUBS)
import health_pb2 as health  # noqa: E402
import health_pb2_grpc as health_rpc  # noqa: E402
import reflection_pb2 as reflection  # noqa: E402
import reflection_pb2_grpc as reflection_rpc  # noqa: E402

SERVICE = "collided.v1.CollisionService"
SERVING, NOT_SERVING = health.HealthCheckResponse.SERVING, health.HealthCheckResponse.NOT_SERVING


class Case(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon(DAEMON, "--grace-seconds", "60")
        self.addCleanup(self.daemon.kill)
        self.channel = grpc.insecure_channel(self.daemon.address)
        self.addCleanup(self.channel.close)


class Health(Case):
    def setUp(self):
        super().setUp()
        self.stub = health_rpc.HealthStub(self.channel)

    def check(self, service):
        return self.stub.Check(health.HealthCheckRequest(service=service), timeout=30).status

    def watch(self, service):
        """Queue of the statuses that the daemon reports for a service."""
        told = queue.Queue()
        statuses = self.stub.Watch(health.HealthCheckRequest(service=service), timeout=120)
        self.addCleanup(statuses.cancel)

        def listen():
            try:
                for answer in statuses:
                    told.put(answer.status)
            except grpc.RpcError as error:
                told.put(error.code())

        threading.Thread(target=listen, daemon=True).start()
        return told

    def test_the_service_and_the_whole_are_told(self):
        for service in ("", SERVICE):
            self.assertEqual(self.check(service), SERVING)

    def test_other_services_are_not_known(self):
        for service in ("collided.v1.Collision", SERVICE + " ", "grpc.health.v1.Health"):
            with self.assertRaises(grpc.RpcError) as caught:
                self.check(service)
            self.assertEqual(caught.exception.code(), grpc.StatusCode.NOT_FOUND)
        self.assertEqual(self.watch("no.Service").get(timeout=30), health.HealthCheckResponse.SERVICE_UNKNOWN)

    def test_a_drain_is_seen_by_those_who_watch(self):
        watches = [self.watch(service) for service in ("", SERVICE)]
        for told in watches:
            self.assertEqual(told.get(timeout=30), SERVING)
        upload, is_over = self.hold()
        self.daemon.process.send_signal(signal.SIGTERM)
        for told in watches:
            self.assertEqual(told.get(timeout=30), NOT_SERVING)
        self.assertEqual(self.check(SERVICE), NOT_SERVING)
        is_over.set()
        self.assertIsNotNone(upload.exception(60))
        self.assertEqual(self.daemon.process.wait(60), 0)

    def hold(self):
        """A call that stays open until its client ends it, so that the daemon waits."""
        is_over = threading.Event()
        self.addCleanup(is_over.set)

        def chunks():
            is_over.wait(120)
            yield from ()

        upload = self.channel.stream_unary(f"/{SERVICE}/UploadMesh").future(chunks(), timeout=120)
        self.channel.unary_unary(f"/{SERVICE}/GetServerInfo")(b"", timeout=30)
        return upload, is_over


class Reflection(Case):
    def ask(self, **question):
        """The answer to one request."""
        stub = reflection_rpc.ServerReflectionStub(self.channel)
        questions = iter([reflection.ServerReflectionRequest(**question)])
        return next(stub.ServerReflectionInfo(questions, timeout=30))

    def pool(self):
        """All files that the service needs, requested one by one."""
        files, wanted = {}, [{"file_containing_symbol": SERVICE}]
        while wanted:
            for packed in self.ask(**wanted.pop()).file_descriptor_response.file_descriptor_proto:
                file = descriptor_pb2.FileDescriptorProto.FromString(packed)
                files[file.name] = file
                wanted += [{"file_by_filename": name} for name in file.dependency if name not in files]
        pool = descriptor_pool.DescriptorPool()

        def add(name):
            for dependency in files[name].dependency:
                add(dependency)
            pool.Add(files[name])

        for name in files:
            add(name)
        return pool

    def test_the_services_are_listed(self):
        listed = {service.name for service in self.ask(list_services="").list_services_response.service}
        self.assertEqual(listed, {SERVICE, "grpc.health.v1.Health", "grpc.reflection.v1.ServerReflection",
                                  "grpc.reflection.v1alpha.ServerReflection"})

    def test_what_is_not_there_is_not_found(self):
        answer = self.ask(file_containing_symbol="no.Service")
        self.assertEqual(answer.error_response.error_code, grpc.StatusCode.NOT_FOUND.value[0])

    def test_the_descriptors_are_enough_to_call(self):
        pool = self.pool()
        service = pool.FindServiceByName(SERVICE)
        self.assertIn("StreamFrames", [method.name for method in service.methods])
        factory = message_factory.MessageFactory(pool)

        def call(name, **fields):
            method = service.FindMethodByName(name)
            send = self.channel.unary_unary(
                f"/{SERVICE}/{name}", factory.GetPrototype(method.input_type).SerializeToString,
                factory.GetPrototype(method.output_type).FromString)
            return send(factory.GetPrototype(method.input_type)(**fields), timeout=30)

        self.assertTrue(call("GetServerInfo").version)
        triangle = b"".join(n.to_bytes(4, "little") for n in (0, 1, 2))
        mesh = {"name": "one", "vertex_count": 3, "triangles": triangle}
        scene = call("CreateScene", spec={"mode": "DETECTION_MODE_CCD", "meshes": [mesh]}).scene
        self.assertEqual((scene.vertex_count, scene.edge_count, scene.triangle_count), (3, 3, 1))
        frame = {"frame_id": 1, "updates": [{"mesh": 0, "positions": bytes(36)}]}
        self.assertFalse(call("DetectFrame", scene_id=scene.scene_id, frame=frame).done.any_contact)
        call("DeleteScene", scene_id=scene.scene_id)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
