// A frame's answer.
#include "server/local/answer.hpp"

#include <algorithm>
#include <cstring>
#include <deque>
#include <utility>

#include "server/convert/chunks.hpp"
#include "server/convert/convert.hpp"
#include "server/local/packets.hpp"
#include "server/service/stream_messages.hpp"

namespace collided::server {
namespace {

constexpr size_t kPage = 4096, kAlignment = 8;
constexpr size_t kMostArrays = 7;
constexpr size_t kInlineBytes = size_t{48} << 10;  // of arrays in one packet
constexpr size_t kNoCut = size_t{1} << 31;         // so that a chunk's count fits its field

// The numbers of SharedArrays' fields are those of ContactChunk's, less those of kind and count.
constexpr int kFieldShift = 2;
static_assert(int{pb::ContactChunk::kElementsFieldNumber} == pb::SharedArrays::kElementsFieldNumber + kFieldShift);
static_assert(int{pb::ContactChunk::kFlagsFieldNumber} == pb::SharedArrays::kFlagsFieldNumber + kFieldShift);

// Contacts go here until there is no room.
class OutputPart {
 public:
  /// `base`: of the output region.
  OutputPart(std::span<std::byte> part, const std::byte* base) : part_(part), base_(base) {}

  size_t room_for(size_t contact_bytes) const {
    const size_t used = used_ + kMostArrays * kAlignment;
    return used >= part_.size() ? 0 : (part_.size() - used) / std::max<size_t>(1, contact_bytes);
  }

  void put(std::span<const std::byte> bytes, pb::SharedRange* range) {
    std::memcpy(part_.data() + used_, bytes.data(), bytes.size());
    range->set_offset(static_cast<uint64_t>(part_.data() + used_ - base_));
    range->set_size(bytes.size());
    used_ += (bytes.size() + kAlignment - 1) / kAlignment * kAlignment;
  }

 private:
  std::span<std::byte> part_;
  const std::byte* base_;
  size_t used_ = 0;
};

void share_chunk(const Chunk& chunk, const Topology& topology, OutputPart& part, pb::ContactChunk* out) {
  out->set_kind(chunk.kind);
  out->set_count(chunk.count());
  pb::SharedArrays* const shared = out->mutable_shared();
  const auto put = [&](int field, std::span<const std::byte> bytes) {
    const auto* range = pb::SharedArrays::descriptor()->FindFieldByNumber(field - kFieldShift);
    part.put(bytes, static_cast<pb::SharedRange*>(shared->GetReflection()->MutableMessage(shared, range)));
  };
  for (const ChunkArray& array : chunk.arrays()) put(array.field, array.bytes);
  const auto stencils = chunk.stencils(topology);
  if (!stencils.empty()) put(pb::ContactChunk::kStencilsFieldNumber, std::as_bytes(std::span(stencils)));
}

class PacketWriter {
 public:
  PacketWriter(const Scene& scene, uint64_t frame_id, OutputPart part)
      : topology_(scene.topology()), frame_id_(frame_id), part_(part) {}

  void put(const Chunk& chunk) {
    const size_t bytes = chunk.fields.contact_bytes();
    const size_t shared = std::min<size_t>(part_.room_for(bytes), chunk.count());
    Chunk piece = chunk;
    piece.end = piece.begin + shared;
    pb::ContactChunk message;
    if (shared > 0) {
      share_chunk(piece, topology_, part_, &message);
      add(std::move(message));
    }
    const size_t step = std::max<size_t>(1, kInlineBytes / std::max<size_t>(1, bytes));
    for (piece.begin = piece.end; piece.begin < chunk.end; piece.begin = piece.end) {
      piece.end = std::min(piece.begin + step, chunk.end);
      message.Clear();
      fill_chunk(piece, topology_, &message);
      add(std::move(message));
    }
  }
  std::vector<std::string> finish(const AnsweredFrame& frame) {
    pb::StreamFramesResponse response;
    response.set_frame_id(frame_id_);
    fill_done(frame.result, frame.cost, response.mutable_done());
    for (auto& piece : last_) *response.mutable_done()->add_contacts() = std::move(piece);
    packets_.push_back(to_packet(std::move(response)));
    return std::move(packets_);
  }

 private:
  /// The last pieces wait for the end of the frame, which has room for some.
  void add(pb::ContactChunk piece) {
    last_bytes_ += piece.ByteSizeLong();
    last_.push_back(std::move(piece));
    while (last_bytes_ > kInlineBytes) {
      last_bytes_ -= last_.front().ByteSizeLong();
      pb::StreamFramesResponse response;
      response.set_frame_id(frame_id_);
      *response.mutable_contacts() = std::move(last_.front());
      packets_.push_back(to_packet(std::move(response)));
      last_.pop_front();
    }
  }

  const Topology& topology_;
  const uint64_t frame_id_;
  OutputPart part_;
  std::vector<std::string> packets_;
  std::deque<pb::ContactChunk> last_;
  size_t last_bytes_ = 0;
};

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
  if (packet.size() <= kMaxPacketBytes) return packet;
  response.mutable_opened()->mutable_scene()->mutable_spec()->clear_meshes();
  return to_packet(std::move(response));
}

AnswerWriter::AnswerWriter(std::shared_ptr<SharedRegion> region, uint32_t window)
    : region_(std::move(region)), window_(window) {}

std::span<std::byte> AnswerWriter::next_part() {
  const uint64_t frame = frames_++;
  if (!region_) return {};
  const size_t bytes = region_->output().size() / window_ / kPage * kPage;
  return region_->output().subspan(frame % window_ * bytes, bytes);
}

std::vector<std::string> AnswerWriter::write(const Scene& scene, AnsweredFrame& frame) {
  const auto begin = std::chrono::steady_clock::now();
  const OutputPart part(next_part(), region_ ? region_->output().data() : nullptr);
  PacketWriter packets(scene, frame.frame_id, part);
  for (const Chunk& chunk : cut_into_chunks(frame.result, scene.plan().fields, kNoCut)) {
    packets.put(chunk);
    frame.cost.bytes_out += chunk.count() * chunk.fields.contact_bytes();
  }
  frame.cost.encode_milliseconds = milliseconds_since(begin);
  frame.cost.total_milliseconds = milliseconds_since(frame.arrival);
  return packets.finish(frame);
}

}  // namespace collided::server
