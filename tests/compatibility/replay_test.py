#!/usr/bin/env python3
"""Clients of each release get the answers that they got: their recorded requests, sent to this daemon, byte for byte.

usage: replay_test.py DAEMON

Answers are compared in every field that the release knew; differences.py names the few that differ each time. Where a change of
answers is intended, README.md says how to record again.
"""

import copy
import pathlib
import sys
import unittest

try:
    import grpc  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio)")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import conversation
from conversation import pack, unpack
from daemon import Daemon
from differences import IGNORED
from replay import Replay

DAEMON = sys.argv[1]
RECORDINGS = sorted((conversation.HERE / "recordings").glob("*/*.jsonl"))
FIRST = conversation.HERE / "recordings/0.1.0"


def replayed(messages, events):
    with Daemon(DAEMON) as daemon:  # of its own, as the recording had
        return Replay(messages, daemon.address, daemon.local).run(events)


class Recordings(unittest.TestCase):
    def test_every_recording_is_answered_as_it_was(self):
        self.assertGreater(len(RECORDINGS), 30)
        for file in RECORDINGS:
            with self.subTest(f"{file.parent.name}/{file.stem}"):
                self.assertEqual(replayed(conversation.Messages(file.parent.name), conversation.read(file)), [])

    def test_what_is_ignored_exists(self):
        messages = conversation.Messages("0.1.0")
        for name in IGNORED:
            message, _, field = name.rpartition(".")
            self.assertIn(field, messages["collided.v1." + message].DESCRIPTOR.fields_by_name, name)


class Altered(unittest.TestCase):
    """Recordings of answers that this daemon does not give."""

    def setUp(self):
        self.messages = conversation.Messages("0.1.0")

    def altered(self, name, change):
        """Alters the first answer that `change` takes: it gets the message, and tells whether it has altered it."""
        events, methods = conversation.read(FIRST / f"{name}.jsonl"), {}
        for event in events:
            if "begin" in event:
                methods[event["call"]] = event["begin"]
            elif "receive" in event:
                message = self.messages.of_call(methods[event["call"]])[1].FromString(unpack(event["receive"]))
                if change(message):
                    event["receive"] = pack(message.SerializeToString())
                    return replayed(self.messages, events)
        raise AssertionError("no answer was altered")

    def test_a_bit_of_a_time_of_impact(self):
        def flip(answer):
            if answer.DESCRIPTOR.name != "StreamFramesResponse":
                return False
            for chunk in answer.done.contacts:
                if chunk.toi:
                    chunk.toi = bytes([chunk.toi[0] ^ 1]) + chunk.toi[1:]
                    return True
            return False

        self.assertRegex(self.altered("ccd_certified_grpc", flip)[0], r"StreamFrames: done\.contacts\[0\]\.toi was .*, is ")

    def test_a_count(self):
        def more(answer):
            if answer.DESCRIPTOR.name != "StreamFramesResponse" or not answer.done.contact_count:
                return False
            answer.done.contact_count += 1
            return True

        found = self.altered("dcd_exact_grpc", more)
        self.assertRegex(found[0], r"StreamFrames: done\.contact_count was \d+, is \d+")

    def test_an_array_in_shared_memory(self):
        events = conversation.read(FIRST / "ccd_exact_local.jsonl")
        event = next(event for event in events if "receive" in event and event.get("memory"))
        data = bytearray(unpack(event["memory"][0][1]))
        data[0] ^= 1
        event["memory"][0][1] = pack(bytes(data))
        self.assertRegex(replayed(self.messages, events)[0], "local: arrays in shared memory differ")

    def test_a_field_that_was_there(self):
        def name(answer):
            if answer.DESCRIPTOR.name != "GetServerInfoResponse":
                return False
            answer.limits.max_window += 1
            return True

        self.assertRegex(self.altered("daemon_and_scenes", name)[0], r"GetServerInfo: limits\.max_window was \d+, is \d+")

    def test_a_code_and_a_field(self):
        for key, value in (("end", 5), ("field", "spec.other")):
            events = conversation.read(FIRST / "bad_inputs.jsonl")
            event = next(event for event in events if event.get("end") == 3)
            event[key] = value
            self.assertRegex(replayed(self.messages, events)[0], "CreateScene: ended with code 3 .*, was code")

    def test_an_answer_more(self):
        events = conversation.read(FIRST / "calls.jsonl")
        at = next(i for i, event in enumerate(events) if "receive" in event)
        events.insert(at, copy.deepcopy(events[at]))
        self.assertRegex(replayed(self.messages, events)[0], "no answer, where there was one")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
