#pragma once
// What a frame says beside its positions.

#include "collided/v1/frame.pb.h"

namespace collided::client {

/// All fields but the updates.
inline void copy_options(const v1::Frame& from, v1::Frame& to) {
  to.set_frame_id(from.frame_id());
  to.set_mode(from.mode());
  to.set_accuracy(from.accuracy());
  if (from.has_delta()) to.set_delta(from.delta());
  to.set_report(from.report());
  to.set_ignore_separating(from.ignore_separating());
  to.set_advance(from.advance());
  to.set_advance_mode(from.advance_mode());
  to.set_trial(from.trial());
  if (from.has_from_last_fraction()) to.set_from_last_fraction(from.from_last_fraction());
  if (from.has_edit()) *to.mutable_edit() = from.edit();
  *to.mutable_worlds() = from.worlds();
  *to.mutable_meshes() = from.meshes();
}

}  // namespace collided::client
