// What the messages of a frame stream mean on every transport.
#include "server/frames/messages.hpp"

#include <algorithm>

#include "proto/constants.hpp"
#include "server/convert/facts.hpp"
#include "server/errors.hpp"
#include "server/refusals/refuse.hpp"
#include "server/sets/world_errors.hpp"

namespace collided::server {
namespace {

uint32_t grant_window(uint32_t wanted, uint32_t limit) {
  if (wanted > limit)
    throw LimitExceeded("open.window", fmt::format("open.window is {}, more than max_window, {}", wanted, limit));
  return wanted ? wanted : std::min(pb::kDefaultWindow, limit);
}

Delivery parse_delivery(pb::DeliveryPolicy delivery) {
  switch (delivery) {
    case pb::DELIVERY_POLICY_UNSPECIFIED:
    case pb::DELIVERY_POLICY_LOSSLESS:
      return Delivery::kLossless;
    case pb::DELIVERY_POLICY_LATEST_WINS:
      return Delivery::kLatestWins;
    default:
      throw_unknown("open.delivery", delivery, {pb::DELIVERY_POLICY_LOSSLESS, pb::DELIVERY_POLICY_LATEST_WINS});
  }
}

}  // namespace

StreamTerms parse_open(const pb::OpenStream& open, const Limits& limits) {
  return {grant_window(open.window(), limits.max_window), parse_delivery(open.delivery())};
}

void fill_error(const Failure& failure, pb::FrameError* out) {
  out->set_code(failure.code);
  out->set_message(failure.message);
  out->set_field(failure.field);
  out->set_retry_after_seconds(failure.retry_after_seconds);
}

pb::StreamFramesResponse opened_message(const Scene& scene, uint32_t window) {
  pb::StreamFramesResponse response;
  fill_scene(scene, response.mutable_opened()->mutable_scene());
  response.mutable_opened()->set_window(window);
  return response;
}

pb::StreamFramesResponse skipped_message(uint64_t frame_id) {
  pb::StreamFramesResponse response;
  response.set_frame_id(frame_id);
  response.mutable_skipped();
  return response;
}

pb::StreamFramesResponse draining_message(double seconds) {
  pb::StreamFramesResponse response;
  response.mutable_draining()->set_deadline_seconds(seconds);
  return response;
}

pb::StreamFramesResponse refusal_message(uint64_t frame_id, const Failure& failure) {
  pb::StreamFramesResponse response;
  response.set_frame_id(frame_id);
  fill_error(failure, response.mutable_error());
  return response;
}

std::vector<pb::StreamFramesResponse> world_error_messages(const AnsweredFrame& frame) {
  std::vector<pb::StreamFramesResponse> messages;
  uint64_t room = 0;
  size_t index = 0;
  for (const RefusedWorld& refused : frame.result.worlds.refused) {
    const uint64_t bytes = index < kMaxWorldMessages ? kWorldErrorBytes : kBareWorldErrorBytes;
    if (bytes > room) {
      room = pb::kMaxPacketBytes / 2;
      messages.emplace_back().set_frame_id(frame.frame_id);
    }
    room -= bytes;
    fill_world_error(refused, index++, {"frame", "frame.updates[0]"},
                     messages.back().mutable_world_errors()->add_errors());
  }
  return messages;
}

}  // namespace collided::server
