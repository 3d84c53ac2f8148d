// Answers of a local stream as packets and shared memory.
#include "server/transport/local/encode.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "proto/constants.hpp"
#include "server/convert/mesh_pairs.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/messages.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxArrays = 8;                   // of a chunk: DCD frames have no times, and sets no solids
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

// Shares as many contacts of the chunk as fit; the others go into inline pieces. `next` makes a piece.
template <class Next>
void put_chunk(const Chunk& chunk, const Topology& topology, OutputPart& part, const Next& next) {
  const size_t bytes = chunk.fields.contact_bytes();
  Chunk piece = chunk;
  piece.end = piece.begin + std::min<size_t>(part.room_for(bytes), chunk.count());
  if (piece.count() > 0)
    share_chunk(piece, piece.make_arrays(topology), next(),
                [&](std::span<const std::byte> array, pb::SharedRange* range) { part.put(array, range); });
  const size_t step = std::max<size_t>(1, kInlineBytes / std::max<size_t>(1, bytes));
  for (piece.begin = piece.end; piece.begin < chunk.end; piece.begin = piece.end) {
    piece.end = std::min(piece.begin + step, chunk.end);
    fill_chunk(piece, topology, next());
  }
}

// Moves a piece of the answer into its end. Of shortened ways and of pairs of meshes there is one at most each: a full
// one leaves no room for the next.
void move_into(pb::FrameDone& done, pb::StreamFramesResponse& piece) {
  if (piece.has_shortened()) *done.mutable_shortened() = std::move(*piece.mutable_shortened());
  if (piece.has_pairs()) *done.mutable_pairs() = std::move(*piece.mutable_pairs());
  if (piece.has_limits()) *done.add_limits() = std::move(*piece.mutable_limits());
  if (piece.has_contacts()) *done.add_contacts() = std::move(*piece.mutable_contacts());
}

std::string done_packet(const AnsweredFrame& frame, std::span<pb::StreamFramesResponse> pieces) {
  pb::StreamFramesResponse response;
  response.set_frame_id(frame.frame_id);
  *response.mutable_done() = done_message(frame);
  for (pb::StreamFramesResponse& piece : pieces) move_into(*response.mutable_done(), piece);
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
  std::vector<pb::StreamFramesResponse> pieces;
  const auto next_piece = [&]() -> pb::StreamFramesResponse& {
    pieces.emplace_back().set_frame_id(frame.frame_id);
    return pieces.back();
  };
  size_t alone = 0;  // of the pieces
  const auto encode = [&](std::span<const Chunk> contacts, std::span<const Chunk> limits) {
    const Topology& topology = scene.engine().topology();
    for (const WaysChunk& ways : cut_into_chunks(frame.result.shortened, kInlineBytes))
      fill_ways(ways, next_piece().mutable_shortened());
    for (const MeshPairStates pairs : cut_into_chunks(frame.result.pair_states, kInlineBytes))
      fill_pairs(pairs, next_piece().mutable_pairs());
    for (const Chunk& chunk : limits) fill_chunk(chunk, topology, next_piece().mutable_limits());
    for_each_kind(
        [&](ContactKind kind, const PlacedContacts& placed) {
          if (placed.count > 0) name_placed(kind, placed, offset, next_piece().mutable_contacts());
        },
        frame.result.placed);
    for (const Chunk& chunk : contacts)
      put_chunk(chunk, topology, part, [&]() { return next_piece().mutable_contacts(); });
    std::vector<size_t> sizes;
    for (const auto& piece : pieces) sizes.push_back(piece.ByteSizeLong());
    alone = pieces.size() - fit_at_end(sizes, kInlineBytes);
    for (size_t i = 0; i < alone; ++i) packets.push_back(to_packet(std::move(pieces[i])));
  };
  encode_contacts(scene, frame, kNoCut, kInlineBytes, encode);
  packets.push_back(done_packet(frame, std::span(pieces).subspan(alone)));
  return packets;
}

}  // namespace collided::server
