#include "server/batch/set_answer.hpp"

#include <spdlog/fmt/fmt.h>

#include <limits>
#include <string_view>

#include "server/errors.hpp"
#include "server/frames/answer.hpp"

namespace collided::server {
namespace {

constexpr std::string_view kFrame = "frame";
constexpr size_t kMostMessages = 256;  // of refused worlds
constexpr uint64_t kErrorBytes = 512, kBareErrorBytes = 16;

std::string path_of(size_t index) { return fmt::format("frames[{}]", index); }

// "updates[5].end" of the engine -> "positions".
std::string field_of(const std::string& engine) {
  const std::string last = engine.substr(engine.rfind('.') + 1);
  if (last == "end" || last == "updates") return "positions";
  if (last == "start") return "start_positions";
  return last == "mesh" ? "meshes" : last;
}

// The engine's sentence begins with its field.
std::string sentence_of(const RefusedWorld& refused, const std::string& field) {
  const bool begins_so = refused.what.starts_with(refused.field);
  return field + (begins_so ? refused.what.substr(refused.field.size()) : ": " + refused.what);
}

void fill_errors(const std::vector<RefusedWorld>& all, size_t index, pb::SetAnswer* out) {
  for (size_t i = 0; i < all.size(); ++i) {
    pb::WorldError& error = *out->add_errors();
    error.set_world(all[i].world);
    error.mutable_error()->set_code(grpc::INVALID_ARGUMENT);
    if (i >= kMostMessages) continue;
    const std::string field = path_of(index) + "." + field_of(all[i].field);
    error.mutable_error()->set_field(field);
    error.mutable_error()->set_message(sentence_of(all[i], field));
  }
}

// Worlds that are not in the frame have no contacts.
std::vector<uint64_t> begins_in_frame(const std::vector<uint64_t>& of_all, const std::vector<uint32_t>& worlds) {
  std::vector<uint64_t> begins;
  begins.reserve(worlds.size() + 1);
  for (const uint32_t world : worlds) begins.push_back(of_all[world]);
  begins.push_back(of_all.back());
  return begins;
}

}  // namespace

Failure at_frame(Failure failure, size_t index) {
  const std::string old = failure.field;
  if (old != kFrame && !old.starts_with("frame.")) return failure;
  failure.field = path_of(index) + old.substr(kFrame.size());
  if (const size_t at = failure.message.find(old); at != std::string::npos)
    failure.message.replace(at, old.size(), failure.field);
  return failure;
}

void AnswerBytes::take(uint64_t frame_id, uint64_t bytes) {
  uint64_t left = left_;
  do {
    if (bytes > left)
      throw LimitExceeded(
          "max_answer_bytes",
          fmt::format("frame {} was applied, but its answer takes {} bytes, and the batch's has room for "
                      "{} of {} (max_answer_bytes); send fewer worlds at a time, or ask for fewer fields",
                      frame_id, bytes, left, max_));
  } while (!left_.compare_exchange_weak(left, left - bytes));
}

void fill_answer(const Scene& set, AnsweredFrame& frame, const std::vector<uint32_t>& worlds, size_t index,
                 AnswerBytes& bytes, pb::SetAnswer* out) {
  const WorldResults& by_world = frame.result.worlds;
  encode_contacts(set, frame, std::numeric_limits<size_t>::max(), [&](std::span<const Chunk> chunks) {
    const size_t messages = std::min(by_world.refused.size(), kMostMessages);
    bytes.take(frame.frame_id, frame.cost.bytes_out + chunks.size() * (worlds.size() + 1) * sizeof(uint64_t) +
                                   messages * kErrorBytes + by_world.refused.size() * kBareErrorBytes);
    for (const Chunk& chunk : chunks) {
      pb::WorldContacts& contacts = *out->add_contacts();
      const std::vector<uint64_t> begins = begins_in_frame(value_of(by_world.begin, chunk.kind), worlds);
      contacts.set_begin(begins.data(), begins.size() * sizeof(uint64_t));
      fill_chunk(chunk, set.topology(), contacts.mutable_contacts());
    }
    fill_errors(by_world.refused, index, out);
  });
  *out->mutable_done() = done_message(frame);
}

}  // namespace collided::server
