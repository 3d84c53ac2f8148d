"""Where a scene is, as its client knows it to the bit: enough to put another daemon's scene there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from collided.frames.advance import Advance
from collided.frames.updates import Update
from collided.layout import Layout
from collided.positions import Format, move_along, move_rigidly, pose_along

_MAX_PATCHES = 64
_AT_REST = np.eye(3, 4)


@dataclass(frozen=True, eq=False)
class Placement:
    """Where one mesh is: positions of the wire, but those of `patches`; or, of a rigid mesh, its first ones and a pose.

    rest: positions that decide what the mesh's exclude_rest_pairs leaves out.
    """

    base: np.ndarray
    rest: np.ndarray
    pose: np.ndarray | None = None
    patches: tuple[tuple[np.ndarray, np.ndarray], ...] = ()

    @cached_property
    def positions(self) -> np.ndarray:
        """Of the wire; the same array each time."""
        if not self.patches:
            return self.base
        out = self.base.copy()
        for indices, values in self.patches:
            out[indices] = values
        return out

    def real(self, form: Format) -> np.ndarray:
        """As the engine has them."""
        first = form.decode(self.positions)
        return first if self.pose is None else move_rigidly(first, self.pose)

    def at_rest(self) -> Placement:
        """Where it is decides what exclude_rest_pairs leaves out."""
        positions = self.positions
        return replace(self, base=positions, rest=positions, patches=()) if self.pose is None else self

    def moved(self, indices: np.ndarray | None, positions: np.ndarray, form: Format) -> Placement:
        """With new positions of the vertices `indices`, or of all."""
        if indices is None:
            return Placement(positions, self.rest, self.pose)
        if self.base.dtype != positions.dtype:  # between the steps of Q16
            positions = form.decode(positions)
        patches = (*self.patches, (indices, positions))
        if len(patches) <= _MAX_PATCHES:
            return replace(self, patches=patches)
        return replace(self, base=replace(self, patches=patches).positions, patches=())


State = dict[int, Placement]


class Way(NamedTuple):
    """From where to where a frame's meshes moved, whether or not they went all of it."""

    start: State
    end: State
    layout: Layout
    form: Format

    def along(self, fraction: float) -> State:
        """Where the scene is after so much of the way."""
        if fraction in (0, 1):
            return self.end if fraction else self.start
        return {i: self._between(self.start[i], end, fraction) for i, end in self.end.items()}

    def gone(self, advance: Advance) -> State:
        """Returns where the scene is after an advance."""
        return {i: end if self.start[i] is end else self._between(self.start[i], end, advance.fraction(i))
                for i, end in self.end.items()}

    def _between(self, start: Placement, end: Placement, fraction: float | np.ndarray) -> Placement:
        if start is end or np.all(fraction == 1):
            return end
        if np.all(fraction == 0):
            return start
        if end.pose is not None and start.pose is not None:
            return replace(end, pose=pose_along(start.pose, end.pose, float(fraction)))  # it goes as a whole
        positions = move_along(start.real(self.form), end.real(self.form), fraction)
        return replace(end, base=positions, patches=())


def way_of(updates: list[Update], before: State, begun: frozenset[int], layout: Layout, form: Format) -> Way:
    """The way of a frame with these updates. begun: meshes that have their first positions in it."""
    start, end = dict(before), dict(before)
    for update in updates:
        old = None if update.mesh in begun else before.get(update.mesh)
        if old is not None and update.positions is not None and layout.mesh(update.mesh).motion != "deformable":
            old = None  # static and rigid meshes that an edit replaced may begin again
        begins, ends = _first(update, layout.mesh(update.mesh).is_rigid) if old is None else _next(update, old, form)
        start[update.mesh], end[update.mesh] = begins, ends
    for index in layout.removed:
        start.pop(index, None)
        end.pop(index, None)
    return Way(start, end, layout, form)


def first_placement(positions: np.ndarray, is_rigid: bool, pose: np.ndarray | None = None) -> Placement:
    """Of a mesh that begins at these positions, moved by a pose if it is rigid."""
    return Placement(positions, positions, (_AT_REST if pose is None else pose) if is_rigid else None)


def _first(update: Update, is_rigid: bool) -> tuple[Placement, Placement]:
    """Of a mesh's first frame, in which it stands still unless it says where it begins."""
    assert update.positions is not None
    end = first_placement(update.positions, is_rigid, update.pose)
    if update.start is not None:
        return replace(end, base=update.start), end
    return (end if update.start_pose is None else replace(end, pose=update.start_pose)), end


def _next(update: Update, old: Placement, form: Format) -> tuple[Placement, Placement]:
    if update.pose is not None:
        return (old if update.start_pose is None else replace(old, pose=update.start_pose)), replace(old, pose=update.pose)
    assert update.positions is not None
    start = old if update.start is None else old.moved(update.indices, update.start, form)
    return start, old.moved(update.indices, update.positions, form)
