#include "server/batch/set_answer.hpp"

#include <spdlog/fmt/fmt.h>

#include <limits>
#include <string_view>

#include "server/errors.hpp"
#include "server/frames/answer.hpp"
#include "server/sets/world_errors.hpp"

namespace collided::server {
namespace {

constexpr std::string_view kFrame = "frame";

std::string path_of(size_t index) { return fmt::format("frames[{}]", index); }

void fill_errors(const std::vector<RefusedWorld>& all, const std::string& path, pb::SetAnswer* out) {
  for (size_t i = 0; i < all.size(); ++i) fill_world_error(all[i], i, {path, path}, out->add_errors());
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
  constexpr size_t kNoCut = std::numeric_limits<size_t>::max();
  const auto encode = [&](std::span<const Chunk> chunks, std::span<const Chunk>) {  // a set's frame has no limits
    const size_t messages = std::min(by_world.refused.size(), kMaxWorldMessages);
    bytes.take(frame.frame_id, frame.cost.bytes_out + chunks.size() * (worlds.size() + 1) * sizeof(uint64_t) +
                                   messages * kWorldErrorBytes + by_world.refused.size() * kBareWorldErrorBytes);
    for (const Chunk& chunk : chunks) {
      pb::WorldContacts& contacts = *out->add_contacts();
      const std::vector<uint64_t> begins = begins_in_frame(value_of(by_world.begin, chunk.kind), worlds);
      contacts.set_begin(begins.data(), begins.size() * sizeof(uint64_t));
      fill_chunk(chunk, set.engine().topology(), contacts.mutable_contacts());
    }
    fill_errors(by_world.refused, path_of(index), out);
  };
  encode_contacts(set, frame, kNoCut, kNoCut, encode);
  *out->mutable_done() = done_message(frame);
}

}  // namespace collided::server
