"""What a frame asks besides its positions."""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np

from collided.arrays import check_length
from collided.choices import check_flag, choice, usable
from collided.errors import InvalidArgument
from collided.frames.edit import Edit
from collided.v1 import frame_pb2, scene_pb2


class FrameOptions(TypedDict, total=False):
    """Settings of one frame; those that are not given are the scene's.

    mode: "dcd" or "ccd", in scenes of "dcd_and_ccd".
    accuracy, delta, report: as in SceneOptions, for this frame.
    ignore_separating: leave features that rest on each other out of `earliest_toi` and the reports of one contact.
    advance: go only as far towards the positions as is certified; `Contacts.advanced` tells how far. True or "all_or_one": the
        scene goes one fraction of the way; "per_mesh": each mesh its own; "per_vertex": each vertex, but rigid meshes as a whole.
    limits: with `advance`, answer with the contacts that limit the way, too: `Contacts.limits`.
    trial: answer, and leave the scene where it was.
    from_last_fraction: begin so far along the way of the last frame, in [0, 1].
    edit: changes of what the scene is made of.
    """

    mode: str | None
    accuracy: str | None
    delta: float | None
    report: str | None
    ignore_separating: bool
    advance: bool | str
    limits: bool
    trial: bool
    from_last_fraction: float | None
    edit: Edit | None


def _flag(options: FrameOptions, name: str) -> bool:
    value = options.get(name)
    return value is not None and check_flag(value, name)


def _advance(value: bool | str | None) -> dict[str, Any]:
    """The fields of a frame that say whether it advances, and what goes its own fraction of the way."""
    enum, prefix = frame_pb2.AdvanceMode, "ADVANCE_MODE_"
    try:
        if isinstance(value, str):
            return {"advance": True, "advance_mode": choice(enum, prefix, value, "advance")}
        return {"advance": value is not None and check_flag(value, "advance")}
    except InvalidArgument:
        raise InvalidArgument(f"advance is {value!r}; it must be True, False or one of {usable(enum, prefix)}",
                              field="advance") from None


_PLAIN = frame_pb2.Frame()


def frame_head(options: FrameOptions) -> frame_pb2.Frame:
    """A frame without its id, its updates and its edit. Without options always the same one."""
    if not options:
        return _PLAIN
    unknown = options.keys() - FrameOptions.__annotations__.keys()
    if unknown:
        known = ", ".join(FrameOptions.__annotations__)
        raise InvalidArgument(f"{min(unknown)!r} is no option of a frame; these are {known}", field=min(unknown))
    head = frame_pb2.Frame(
        mode=choice(scene_pb2.DetectionMode, "DETECTION_MODE_", options.get("mode"), "mode"),
        accuracy=choice(scene_pb2.Accuracy, "ACCURACY_", options.get("accuracy"), "accuracy"),
        report=choice(scene_pb2.Report, "REPORT_", options.get("report"), "report"),
        ignore_separating=_flag(options, "ignore_separating"), limits=_flag(options, "limits"), trial=_flag(options, "trial"),
        **_advance(options.get("advance")))
    delta, fraction = options.get("delta"), options.get("from_last_fraction")
    if delta is not None:
        check_length(delta, "delta")
        head.delta = delta
    if fraction is not None:
        if not isinstance(fraction, (int, float, np.number)) or not 0 <= fraction <= 1:
            raise InvalidArgument(f"from_last_fraction is {fraction!r}; it must be from 0 to 1", field="from_last_fraction")
        head.from_last_fraction = fraction
    return head
