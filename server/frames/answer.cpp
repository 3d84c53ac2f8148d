// A frame's answer: its contacts in chunks, its cost, its last message.
#include "server/frames/answer.hpp"

#include "server/convert/frame.hpp"
#include "server/convert/mesh_pairs.hpp"

namespace collided::server {

void encode_contacts(
    const Scene& scene, AnsweredFrame& frame, size_t max_chunk_bytes, size_t max_limit_bytes,
    const std::function<void(std::span<const Chunk> contacts, std::span<const Chunk> limits)>& encode) {
  const auto begin = Clock::now();
  OutputFields fields = scene.plan()->fields;
  fields.worlds = frame.tells_worlds;
  const auto chunks = cut_into_chunks(frame.result, fields, max_chunk_bytes, &frame.result.worlds.begin);
  const auto limits = cut_into_chunks(frame.result.limits, kLimitFields, max_limit_bytes);
  frame.cost.bytes_out += array_bytes(frame.result.shortened) + array_bytes(frame.result.pair_states);
  for (const auto* all : {&chunks, &limits})
    for (const Chunk& chunk : *all) frame.cost.bytes_out += chunk.array_bytes();
  for_each_kind(
      [&](ContactKind, const PlacedContacts& placed) {
        for (const PlacedArray& array : arrays_of(placed)) frame.cost.bytes_out += array.range.bytes;
      },
      frame.result.placed);
  encode(chunks, limits);
  frame.cost.encode_milliseconds = milliseconds_since(begin);
  frame.cost.total_milliseconds = milliseconds_since(frame.arrival);
}

pb::FrameDone done_message(const AnsweredFrame& frame) {
  pb::FrameDone done;
  fill_result(frame.result, &done);
  pb::FrameMetrics& metrics = *done.mutable_metrics();
  const FrameCost& cost = frame.cost;
  metrics.set_total_milliseconds(cost.total_milliseconds);
  metrics.set_queue_milliseconds(cost.queue_milliseconds);
  metrics.set_decode_milliseconds(cost.decode_milliseconds);
  metrics.set_engine_milliseconds(cost.engine_milliseconds);
  metrics.set_encode_milliseconds(cost.encode_milliseconds);
  metrics.set_device_bytes(cost.device_bytes);
  metrics.set_bytes_in(cost.bytes_in);
  metrics.set_bytes_out(cost.bytes_out);
  return done;
}

}  // namespace collided::server
