// Bounds a message's memory before it is parsed.
#include "server/convert/wire_bounds.hpp"

#include <google/protobuf/wire_format_lite.h>

#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;

constexpr int kMaxDepth = 32;  // ours nest four deep

bool is_message(const FieldDescriptor* field) { return field && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE; }

bool is_packed_array(const FieldDescriptor* field) { return field && field->is_packable(); }

}  // namespace

void FieldCount::add_message(const std::string& bytes, const Type& type, std::string path) {
  Input in(reinterpret_cast<const uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
  in.PushLimit(static_cast<int>(bytes.size()));
  add_message(in, type, std::move(path));
}

void FieldCount::add_message(Input& in, const Type& type, std::string path) {
  path_ = std::move(path);
  add_fields(in, &type, 0);
  if (!in.ConsumedEntireMessage()) throw_malformed();
}

// `type` is null within unknown groups. Ends at the end of the message, or after a tag that ends a group, which ends
// no message.
void FieldCount::add_fields(Input& in, const Type* type, int depth) {
  if (depth > kMaxDepth) throw_invalid(path_, fmt::format("nests more than {} levels deep", kMaxDepth));
  while (const uint32_t tag = in.ReadTag()) {
    if (WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_END_GROUP) return;
    add();
    add_field(in, tag, type, depth);
  }
}

void FieldCount::add_field(Input& in, uint32_t tag, const Type* type, int depth) {
  const int number = WireFormatLite::GetTagFieldNumber(tag);
  if (number == 0) throw_malformed();
  uint64_t value = 0;
  switch (WireFormatLite::GetTagWireType(tag)) {
    case WireFormatLite::WIRETYPE_VARINT:
      return in.ReadVarint64(&value) ? void() : throw_malformed();
    case WireFormatLite::WIRETYPE_FIXED64:
      return in.ReadLittleEndian64(&value) ? void() : throw_malformed();
    case WireFormatLite::WIRETYPE_FIXED32:
      return in.Skip(sizeof(uint32_t)) ? void() : throw_malformed();
    case WireFormatLite::WIRETYPE_LENGTH_DELIMITED:
      return add_delimited(in, type ? type->FindFieldByNumber(number) : nullptr, depth);
    case WireFormatLite::WIRETYPE_START_GROUP:
      return add_group(in, tag, depth);
    default:
      throw_malformed();
  }
}

void FieldCount::add_delimited(Input& in, const FieldDescriptor* field, int depth) {
  int size = 0;
  if (!in.ReadVarintSizeAsInt(&size) || in.BytesUntilLimit() < size) throw_malformed();
  if (!is_message(field)) {
    if (is_packed_array(field)) add(static_cast<uint64_t>(size) / kPackedBytesOfField);
    if (!in.Skip(size)) throw_malformed();
    return;
  }
  const size_t length = path_.size();
  path_.append(".").append(field->name());
  const auto limit = in.PushLimit(size);
  add_fields(in, field->message_type(), depth + 1);
  if (!in.ConsumedEntireMessage()) throw_malformed();
  in.PopLimit(limit);
  path_.resize(length);
}

void FieldCount::add_group(Input& in, uint32_t start, int depth) {
  add_fields(in, nullptr, depth + 1);
  const int number = WireFormatLite::GetTagFieldNumber(start);
  if (!in.LastTagWas(WireFormatLite::MakeTag(number, WireFormatLite::WIRETYPE_END_GROUP))) throw_malformed();
}

void FieldCount::throw_malformed() const {
  throw InvalidInput(path_, path_ + " is cut off or malformed: its bytes are not such a message");
}

void FieldCount::throw_too_many() const {
  throw LimitExceeded(what_, fmt::format("{} has more than {} fields, the maximum here", what_, max_));
}

}  // namespace collided::server
