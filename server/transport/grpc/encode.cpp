// Encodes answers of the frame stream.
#include "server/transport/grpc/encode.hpp"

#include <google/protobuf/wire_format_lite.h>

#include <array>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include "server/convert/mesh_pairs.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/messages.hpp"

namespace collided::server {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

constexpr size_t kFewBytes = 1024;  // smaller arrays are copied into the head instead of sent as slices

uint32_t tag_of(int field, WireFormatLite::WireType type) { return WireFormatLite::MakeTag(field, type); }

void put_varint(std::string& out, uint64_t value) {
  std::array<uint8_t, 10> bytes{};
  const uint8_t* end = CodedOutputStream::WriteVarint64ToArray(value, bytes.data());
  out.append(reinterpret_cast<const char*>(bytes.data()), static_cast<size_t>(end - bytes.data()));
}

void put_number(std::string& out, int field, uint64_t value) {
  put_varint(out, tag_of(field, WireFormatLite::WIRETYPE_VARINT));
  put_varint(out, value);
}

void put_length(std::string& out, int field, size_t bytes) {
  put_varint(out, tag_of(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED));
  put_varint(out, bytes);
}

size_t length_of(int field, size_t bytes) {
  return CodedOutputStream::VarintSize32(tag_of(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED)) +
         CodedOutputStream::VarintSize64(bytes) + bytes;
}

// A slice of memory that `owner` keeps alive.
grpc::Slice borrow(std::span<const std::byte> bytes, std::shared_ptr<const void> owner) {
  auto* held = new std::shared_ptr<const void>(std::move(owner));
  return {const_cast<std::byte*>(bytes.data()), bytes.size(),
          [](void* user) { delete static_cast<std::shared_ptr<const void>*>(user); }, held};
}

// The slices of one message: arrays, with heads in between.
class SliceWriter {
 public:
  std::string& head() { return head_; }

  void put(std::span<const std::byte> bytes, const std::shared_ptr<const void>& owner) {
    if (bytes.size() <= kFewBytes) {
      head_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      return;
    }
    flush();
    slices_.push_back(borrow(bytes, owner));
  }
  EncodedMessage finish() {
    flush();
    EncodedMessage message{grpc::ByteBuffer(slices_.data(), slices_.size()), 0, false};
    message.size = message.bytes.Length();
    return message;
  }

 private:
  void flush() {
    if (head_.empty()) return;
    slices_.emplace_back(head_);
    head_.clear();
  }

  std::string head_;
  std::vector<grpc::Slice> slices_;
};

// Says which field of StreamFramesResponse, and which of FrameDone, holds a message.
struct Place {
  int field = 0, field_of_done = 0;
};
constexpr Place kWays{pb::StreamFramesResponse::kShortenedFieldNumber, pb::FrameDone::kShortenedFieldNumber};
constexpr Place kPairs{pb::StreamFramesResponse::kPairsFieldNumber, pb::FrameDone::kPairsFieldNumber};
constexpr Place kLimits{pb::StreamFramesResponse::kLimitsFieldNumber, pb::FrameDone::kLimitsFieldNumber};
constexpr Place kContacts{pb::StreamFramesResponse::kContactsFieldNumber, pb::FrameDone::kContactsFieldNumber};

// A ContactChunk, ShortenedWays or MeshPairs, ready to be written.
struct Piece {
  Place place = {};
  std::string facts = {};
  size_t packed_bytes = 0;  ///< of arrays, in `facts`
  std::vector<ChunkArray> arrays = {};
  std::shared_ptr<const MadeArrays> made = {};
  size_t stored = 0;  ///< of the arrays; the others are made
  size_t size = 0;    ///< of the message

  size_t array_bytes() const {
    return std::accumulate(arrays.begin(), arrays.end(), packed_bytes,
                           [](size_t sum, const ChunkArray& array) { return sum + array.bytes.size(); });
  }
};

void complete_size(Piece& piece) {
  piece.size = piece.facts.size();
  for (const auto& array : piece.arrays) piece.size += length_of(array.field, array.bytes.size());
}

Piece make_piece(const WaysChunk& ways) {
  Piece piece{kWays};
  const auto arrays = ways.arrays();
  piece.arrays.assign(arrays.begin(), arrays.end());
  piece.stored = piece.arrays.size();
  complete_size(piece);
  return piece;
}

Piece make_piece(MeshPairStates pairs) {
  pb::MeshPairs message;
  fill_pairs(pairs, &message);
  Piece piece{kPairs, message.SerializeAsString(), array_bytes(pairs)};
  complete_size(piece);
  return piece;
}

Piece make_piece(const Place& place, const Chunk& chunk, const Topology& topology) {
  Piece piece{place};
  piece.made = std::make_shared<const MadeArrays>(chunk.make_arrays(topology));
  piece.arrays = chunk.arrays();
  piece.stored = piece.arrays.size();
  for (const ChunkArray& array : piece.made->arrays()) piece.arrays.push_back(array);
  put_number(piece.facts, pb::ContactChunk::kKindFieldNumber, static_cast<uint64_t>(to_message(chunk.kind)));
  put_number(piece.facts, pb::ContactChunk::kCountFieldNumber, chunk.count());
  complete_size(piece);
  return piece;
}

void put_piece(SliceWriter& out, int field, const Piece& piece, const std::shared_ptr<AnsweredFrame>& frame) {
  put_length(out.head(), field, piece.size);
  out.head() += piece.facts;
  for (size_t i = 0; i < piece.arrays.size(); ++i) {
    const ChunkArray& array = piece.arrays[i];
    put_length(out.head(), array.field, array.bytes.size());
    out.put(array.bytes, i < piece.stored ? std::shared_ptr<const void>(frame) : piece.made);
  }
}

EncodedMessage encode_piece(const Piece& piece, const std::shared_ptr<AnsweredFrame>& frame) {
  SliceWriter out;
  put_number(out.head(), pb::StreamFramesResponse::kFrameIdFieldNumber, frame->frame_id);
  put_piece(out, piece.place.field, piece, frame);
  return out.finish();
}

EncodedMessage encode_done(std::span<const Piece> pieces, const std::shared_ptr<AnsweredFrame>& frame) {
  const pb::FrameDone done = done_message(*frame);
  size_t size = done.ByteSizeLong();
  for (const auto& piece : pieces) size += length_of(piece.place.field_of_done, piece.size);

  SliceWriter out;
  put_number(out.head(), pb::StreamFramesResponse::kFrameIdFieldNumber, frame->frame_id);
  put_length(out.head(), pb::StreamFramesResponse::kDoneFieldNumber, size);
  done.AppendToString(&out.head());
  for (const auto& piece : pieces) put_piece(out, piece.place.field_of_done, piece, frame);
  EncodedMessage message = out.finish();
  message.ends_frame = true;
  return message;
}

}  // namespace

EncodedMessage encode(const pb::StreamFramesResponse& response) {
  SliceWriter out;
  response.AppendToString(&out.head());
  EncodedMessage message = out.finish();
  message.ends_frame = response.has_error() || response.has_skipped();
  return message;
}

std::vector<EncodedMessage> encode_answer(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame,
                                          size_t max_chunk_bytes) {
  std::vector<EncodedMessage> messages;
  for (const pb::StreamFramesResponse& errors : world_error_messages(*frame)) messages.push_back(encode(errors));
  size_t alone = 0;  // of the pieces
  std::vector<Piece> pieces;
  const auto encode_pieces = [&](std::span<const Chunk> contacts, std::span<const Chunk> limits) {
    const Topology& topology = scene.engine().topology();
    for (const WaysChunk& ways : cut_into_chunks(frame->result.shortened, max_chunk_bytes))
      pieces.push_back(make_piece(ways));
    for (const MeshPairStates pairs : cut_into_chunks(frame->result.pair_states, max_chunk_bytes))
      pieces.push_back(make_piece(pairs));
    for (const Chunk& chunk : limits) pieces.push_back(make_piece(kLimits, chunk, topology));
    for (const Chunk& chunk : contacts) pieces.push_back(make_piece(kContacts, chunk, topology));
    std::vector<size_t> sizes;
    for (const Piece& piece : pieces) sizes.push_back(piece.array_bytes());
    alone = pieces.size() - fit_at_end(sizes, max_chunk_bytes);
    for (size_t i = 0; i < alone; ++i) messages.push_back(encode_piece(pieces[i], frame));
  };
  encode_contacts(scene, *frame, max_chunk_bytes, max_chunk_bytes, encode_pieces);
  messages.push_back(encode_done(std::span(pieces).subspan(alone), frame));
  return messages;
}

}  // namespace collided::server
