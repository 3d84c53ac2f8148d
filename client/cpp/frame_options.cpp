// Turns the options of a frame into its message.

#include "client/cpp/frame_options.hpp"

namespace collided::client {

v1::Frame frame_head(uint64_t frame_id, const FrameOptions& options) {
  v1::Frame head;
  head.set_frame_id(frame_id);
  head.set_mode(options.mode);
  head.set_accuracy(options.accuracy);
  if (options.delta) head.set_delta(*options.delta);
  head.set_report(options.report);
  head.set_ignore_separating(options.ignore_separating);
  head.set_advance(options.advance);
  head.set_advance_mode(options.advance_mode);
  head.set_limits(options.limits);
  head.set_trial(options.trial);
  if (options.from_last_fraction) head.set_from_last_fraction(*options.from_last_fraction);
  if (options.edit) *head.mutable_edit() = *options.edit;
  head.mutable_worlds()->Assign(options.worlds.begin(), options.worlds.end());
  head.mutable_meshes()->Assign(options.meshes.begin(), options.meshes.end());
  return head;
}

void copy_head(const v1::Frame& from, v1::Frame& to) {
  to.set_frame_id(from.frame_id());
  to.set_mode(from.mode());
  to.set_accuracy(from.accuracy());
  if (from.has_delta()) to.set_delta(from.delta());
  to.set_report(from.report());
  to.set_ignore_separating(from.ignore_separating());
  to.set_advance(from.advance());
  to.set_advance_mode(from.advance_mode());
  to.set_limits(from.limits());
  to.set_trial(from.trial());
  if (from.has_from_last_fraction()) to.set_from_last_fraction(from.from_last_fraction());
  if (from.has_edit()) *to.mutable_edit() = from.edit();
  *to.mutable_worlds() = from.worlds();
  *to.mutable_meshes() = from.meshes();
}

}  // namespace collided::client
