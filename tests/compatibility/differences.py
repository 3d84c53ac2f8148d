"""Compares answers in every field that the release knew, except those that are not the same twice."""

from conversation import is_message, is_repeated

# Fields that may differ from the recording, by their full names without `collided.v1.`, and why.
CLOCK, MACHINE, MEMORY, CHOSEN, TEXT = ("a time, or how long memory of a deleted scene takes to be freed", "of the machine or the build", "a figure of memory",
                                        "chosen by the daemon, and substituted where the client repeats it", "words for people; codes and fields are compared")
IGNORED = {
    "GetServerInfoResponse.version": MACHINE,
    "GetServerInfoResponse.local_socket": MACHINE,
    "Device.name": MACHINE,
    "Device.memory_bytes": MACHINE,
    "Device.max_bytes": MACHINE,
    "Device.free_bytes": MEMORY,
    "Device.load": CLOCK,
    "Device.scenes": CLOCK,
    "ServerLimits.max_scene_bytes": MACHINE,
    "ServerLimits.max_device_bytes": MACHINE,
    "ServerLimits.max_device_bytes_per_client": MACHINE,
    "SceneSpec.memory_budget_bytes": MACHINE,
    "Scene.device": MACHINE,
    "Scene.scene_id": CHOSEN,
    "Scene.resume_token": CHOSEN,
    "SetAnswer.scene_id": CHOSEN,
    "ListScenesResponse.next_page_token": CHOSEN,
    "EstimateSceneResponse.device": MACHINE,
    "MemoryPart.bytes": MEMORY,
    "StageTime.milliseconds": CLOCK,
    "FrameMetrics.total_milliseconds": CLOCK,
    "FrameMetrics.queue_milliseconds": CLOCK,
    "FrameMetrics.step_milliseconds": CLOCK,
    "FrameMetrics.decode_milliseconds": CLOCK,
    "FrameMetrics.engine_milliseconds": CLOCK,
    "FrameMetrics.encode_milliseconds": CLOCK,
    "FrameMetrics.octree_milliseconds": CLOCK,
    "FrameMetrics.lbvh_milliseconds": CLOCK,
    "FrameMetrics.all_pairs_milliseconds": CLOCK,
    "FrameMetrics.list_milliseconds": CLOCK,
    "FrameMetrics.search_milliseconds": CLOCK,
    "FrameMetrics.device_bytes": MEMORY,
    "FrameMetrics.allocations": MEMORY,
    "FrameMetrics.replays": MEMORY,
    "FrameError.message": TEXT,
    "LocalClosed.message": TEXT,
    "SharedRange.offset": CHOSEN,
}


def differences(recorded, answered, path=""):
    """Says where a message differs, and how."""
    for field in recorded.DESCRIPTOR.fields:
        name = field.full_name.removeprefix("collided.v1.")
        if name in IGNORED:
            continue
        at = f"{path}.{field.name}" if path else field.name
        was, now = getattr(recorded, field.name), getattr(answered, field.name)
        if is_repeated(field):
            if len(was) != len(now):
                yield f"{at} had {len(was)} entries, has {len(now)}"
            elif is_message(field):
                for i, (a, b) in enumerate(zip(was, now)):
                    yield from differences(a, b, f"{at}[{i}]")
            elif list(was) != list(now):
                yield f"{at} was {_short(list(was))}, is {_short(list(now))}"
        elif field.has_presence and recorded.HasField(field.name) != answered.HasField(field.name):
            yield f"{at} was {'there' if recorded.HasField(field.name) else 'absent'}, is not"
        elif is_message(field):
            if recorded.HasField(field.name):
                yield from differences(was, now, at)
        elif was != now and not (was != was and now != now):
            yield f"{at} was {_short(was)}, is {_short(now)}"


def _short(value):
    text = value.hex() if isinstance(value, bytes) else repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
