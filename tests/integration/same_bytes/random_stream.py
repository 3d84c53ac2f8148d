"""Streams of frames by chance: a scene, its options, and frames of all kinds, the same for the same seed."""

import random
from dataclasses import dataclass, field

import numpy as np
from recovery_test import sheet
from support import ONE

import collided

LEVELS = ("fast", "guarded", "certified", "exact")
ADVANCING = ("certified", "exact")


@dataclass(frozen=True)
class Frame:
    """What `Session.send` is given."""

    positions: dict
    start: dict | None = None
    options: dict = field(default_factory=dict)


class RandomStream:
    """A cloth that waves through a ground and itself, a rigid ball, and what frames may do with them."""

    def __init__(self, seed, is_plain=False):
        """is_plain: all that a set of scenes can have, too: no poses, no edits, no sparse frames."""
        self._rng = random.Random(seed)
        self._is_plain = is_plain
        self.seed = seed
        self._cells = self._rng.randint(4, 9)
        self._start, self._triangles = sheet(self._cells, 0.06)
        self._number = np.dtype(self._rng.choice(("<f4", "<f8")))
        self.options = self._scene_options()
        self._has_extra, self._last = False, None
        self.frames = [self._frame(step) for step in range(1, 17)]

    @property
    def reuses(self):
        """Whether its scene may have lists of neighbours."""
        return "tt" not in self.options["kinds"]

    def meshes(self):
        ground, triangles = sheet(6, 0)
        out = {"ground": collided.Mesh(ground.astype(self._number), triangles, motion="static"),
               "cloth": collided.Mesh(self._start.astype(self._number), self._triangles)}
        if not self._is_plain:
            ball = np.array([[0.4, 0.4, 0.2], [0.6, 0.4, 0.2], [0.5, 0.6, 0.1]], self._number)
            out["ball"] = collided.Mesh(ball, ONE, motion="rigid")
        return out

    def _scene_options(self):
        rng = self._rng
        mode = rng.choice(("ccd", "dcd") if self._is_plain else ("ccd", "dcd", "dcd_and_ccd"))
        kinds = ("vt", "ee", "tt") if mode == "dcd" and rng.random() < 0.3 else ("vt", "ee")
        return {"mode": mode, "kinds": kinds, "accuracy": rng.choice(LEVELS),
                "thickness": rng.choice((0.0, 0.02)) if mode == "ccd" else 0.03,
                "position_format": "f32" if self._number.itemsize == 4 else "f64"}

    def _cloth(self):
        """Where the cloth goes: up or down, and crumpled."""
        rng = self._rng
        phase, depth, crumple = rng.uniform(0, 6), rng.uniform(-0.05, 0.08), rng.choice((0.0, 0.01, 0.05))
        x, y = self._start[:, 0], self._start[:, 1]
        moved = self._start - np.stack([crumple * np.sin(20 * y + phase), crumple * np.cos(17 * x), depth + 0 * x], axis=1)
        return moved.astype(self._number)

    def _frame(self, step):
        """`from_last_fraction` not after what may be refused: whether a scene has a last way then is its own affair."""
        kinds = [self._whole, self._started, self._trial]
        if not self._is_plain:
            kinds += [self._sparse, self._pose, self._fraction, self._edit, self._report, self._level, self._mode, self._advance]
        if self._last not in (self._whole, self._sparse, self._trial):
            kinds = [kind for kind in kinds if kind != self._fraction]
        self._last = self._whole if step == 1 else self._rng.choice(kinds)
        return self._last(step)

    def _whole(self, _):
        return Frame({"cloth": self._cloth()})

    def _started(self, _):
        if self.options["mode"] == "dcd":
            return self._whole(_)
        return Frame({"cloth": self._cloth()}, {"cloth": self._cloth()})

    def _trial(self, _):
        return Frame({"cloth": self._cloth()}, options={} if self._is_plain else {"trial": True})

    def _sparse(self, _):
        some = sorted(self._rng.sample(range(len(self._start)), self._rng.randint(1, len(self._start))))
        return Frame({"cloth": collided.Sparse(np.array(some), self._cloth()[some])})

    def _pose(self, step):
        """Mostly shifted, at times turned."""
        angle = 0.3 * step if self._rng.random() < 0.3 else 0.0
        turn = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
        return Frame({"ball": collided.Rigid(np.hstack([turn, [[0.01 * step], [0], [-0.02 * step]]]))})

    def _fraction(self, _):
        return Frame({"cloth": self._cloth()}, options={"from_last_fraction": self._rng.choice((0.0, 0.25, 0.3, 1.0))})

    def _edit(self, step):
        """There is an extra triangle after every other edit."""
        extra = collided.Mesh(np.array([[0.1, 0.2, 0.3], [0.9, 0.2, 0], [0.1, 0.9, 0.01 * step]], self._number), ONE)
        self._has_extra = not self._has_extra
        return Frame({"cloth": self._cloth()}, options={"edit": collided.Edit({"extra": extra if self._has_extra else None})})

    def _report(self, _):
        return Frame({"cloth": self._cloth()}, options={"report": self._rng.choice(("earliest_only", "any_hit"))})

    def _level(self, _):
        return Frame({"cloth": self._cloth()}, options={"accuracy": self._rng.choice(LEVELS)})

    def _mode(self, _):
        return Frame({"cloth": self._cloth()}, options={"mode": self._rng.choice(("ccd", "dcd"))})

    def _advance(self, step):
        pose = self._pose(step).positions if self._rng.random() < 0.3 else {}
        return Frame({"cloth": self._cloth()} | pose, options={"advance": True, "accuracy": self._rng.choice(ADVANCING)})
