// Answers of a local stream as packets and shared memory.
#include "server/transport/local/encode.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "proto/constants.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/messages.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxArrays = 8;                   // of a chunk
constexpr size_t kInlineBytes = size_t{48} << 10;  // of arrays in one packet
constexpr size_t kNoCut = size_t{1} << 31;         // so that a chunk's count fits its field

// One frame's part of the output region.
class OutputPart {
 public:
  /// `offset`: in the output region.
  OutputPart(std::span<std::byte> part, uint64_t offset) : part_(part), offset_(offset) {}

  size_t room_for(size_t contact_bytes) const {
    const size_t used = used_ + kMaxArrays * pb::kRangeAlignment;
    return used >= part_.size() ? 0 : (part_.size() - used) / std::max<size_t>(1, contact_bytes);
  }

  void put(std::span<const std::byte> bytes, pb::SharedRange* range) {
    std::memcpy(part_.data() + used_, bytes.data(), bytes.size());
    range->set_offset(offset_ + used_);
    range->set_size(bytes.size());
    used_ += (bytes.size() + pb::kRangeAlignment - 1) / pb::kRangeAlignment * pb::kRangeAlignment;
  }

 private:
  std::span<std::byte> part_;
  const uint64_t offset_;
  size_t used_ = 0;
};

// Contacts that the device has put into the part at `offset`.
void name_placed(ContactKind kind, const PlacedContacts& placed, uint64_t offset, pb::ContactChunk* out) {
  out->set_kind(to_message(kind));
  out->set_count(static_cast<uint32_t>(placed.count));
  pb::SharedArrays* const shared = out->mutable_shared();  // there even if no array was asked for
  for (const auto& [field, array] : arrays_of(placed)) {
    pb::SharedRange* const range = range_of(shared, field);
    range->set_offset(offset + array.offset);
    range->set_size(array.bytes);
  }
}

// Shares as many contacts of the chunk as fit; the others go into inline pieces.
void put_chunk(const Chunk& chunk, const Topology& topology, OutputPart& part, std::vector<pb::ContactChunk>& pieces) {
  const size_t bytes = chunk.fields.contact_bytes();
  Chunk piece = chunk;
  piece.end = piece.begin + std::min<size_t>(part.room_for(bytes), chunk.count());
  if (piece.count() > 0)
    share_chunk(piece, piece.make_arrays(topology), &pieces.emplace_back(),
                [&](std::span<const std::byte> array, pb::SharedRange* range) { part.put(array, range); });
  const size_t step = std::max<size_t>(1, kInlineBytes / std::max<size_t>(1, bytes));
  for (piece.begin = piece.end; piece.begin < chunk.end; piece.begin = piece.end) {
    piece.end = std::min(piece.begin + step, chunk.end);
    fill_chunk(piece, topology, &pieces.emplace_back());
  }
}

std::vector<pb::ShortenedWays> make_ways(const ShortenedWays& shortened) {
  std::vector<pb::ShortenedWays> ways;
  for (const WaysChunk& chunk : cut_into_chunks(shortened, kInlineBytes)) fill_ways(chunk, &ways.emplace_back());
  return ways;
}

std::string ways_packet(uint64_t frame_id, pb::ShortenedWays piece) {
  pb::StreamFramesResponse response;
  response.set_frame_id(frame_id);
  *response.mutable_shortened() = std::move(piece);
  return to_packet(std::move(response));
}

std::string contacts_packet(uint64_t frame_id, pb::ContactChunk piece) {
  pb::StreamFramesResponse response;
  response.set_frame_id(frame_id);
  *response.mutable_contacts() = std::move(piece);
  return to_packet(std::move(response));
}

// `ways`: the last piece, if any; a full one never fits.
std::string done_packet(const AnsweredFrame& frame, std::span<pb::ShortenedWays> ways,
                        std::span<pb::ContactChunk> pieces) {
  pb::StreamFramesResponse response;
  response.set_frame_id(frame.frame_id);
  *response.mutable_done() = done_message(frame);
  for (auto& piece : ways) *response.mutable_done()->mutable_shortened() = std::move(piece);
  for (auto& piece : pieces) *response.mutable_done()->add_contacts() = std::move(piece);
  return to_packet(std::move(response));
}

}  // namespace

std::string to_packet(pb::StreamFramesResponse response) {
  pb::LocalResponse packet;
  *packet.mutable_frame() = std::move(response);
  return packet.SerializeAsString();
}

std::string closed_packet(const Failure& why) {
  pb::LocalResponse packet;
  packet.mutable_closed()->set_code(why.code);
  packet.mutable_closed()->set_message(why.message);
  packet.mutable_closed()->set_field(why.field);
  return packet.SerializeAsString();
}

std::string opened_packet(const Scene& scene, uint32_t window) {
  pb::StreamFramesResponse response = opened_message(scene, window);
  std::string packet = to_packet(response);
  if (packet.size() <= pb::kMaxPacketBytes) return packet;
  response.mutable_opened()->mutable_scene()->mutable_spec()->clear_meshes();
  return to_packet(std::move(response));
}

AnswerWriter::AnswerWriter(std::shared_ptr<SharedRegion> region, uint32_t window)
    : region_(std::move(region)), window_(window) {}

std::vector<std::string> AnswerWriter::write(const Scene& scene, AnsweredFrame& frame) {
  const auto memory = region_ ? region_->output_part(frames_, window_) : std::span<std::byte>();
  const uint64_t offset = region_ ? static_cast<uint64_t>(memory.data() - region_->output().data()) : 0;
  ++frames_;
  OutputPart part(region_ && region_->has_device_output() ? std::span<std::byte>() : memory, offset);
  std::vector<std::string> packets;
  for (pb::StreamFramesResponse& errors : world_error_messages(frame)) packets.push_back(to_packet(std::move(errors)));
  std::vector<pb::ShortenedWays> ways = make_ways(frame.result.shortened);
  size_t ways_alone = 0, alone = 0;  // of the ways, and of the pieces
  std::vector<pb::ContactChunk> pieces;
  for_each_kind(
      [&](ContactKind kind, const PlacedContacts& placed) {
        if (placed.count > 0) name_placed(kind, placed, offset, &pieces.emplace_back());
      },
      frame.result.placed);
  encode_contacts(scene, frame, kNoCut, [&](std::span<const Chunk> chunks) {
    for (const Chunk& chunk : chunks) put_chunk(chunk, scene.engine().topology(), part, pieces);
    std::vector<size_t> sizes;
    for (const auto& piece : ways) sizes.push_back(piece.ByteSizeLong());
    for (const auto& piece : pieces) sizes.push_back(piece.ByteSizeLong());
    const size_t all_alone = sizes.size() - fit_at_end(sizes, kInlineBytes);
    ways_alone = std::min(all_alone, ways.size());
    alone = all_alone - ways_alone;
    for (size_t i = 0; i < ways_alone; ++i) packets.push_back(ways_packet(frame.frame_id, std::move(ways[i])));
    for (size_t i = 0; i < alone; ++i) packets.push_back(contacts_packet(frame.frame_id, std::move(pieces[i])));
  });
  packets.push_back(done_packet(frame, std::span(ways).subspan(ways_alone), std::span(pieces).subspan(alone)));
  return packets;
}

}  // namespace collided::server
