// Packed little-endian arrays to vectors.

#include "client/cpp/contacts.hpp"

#include <bit>
#include <cstring>
#include <string>

#include "client/cpp/error.hpp"

namespace collided::client {

// The wire is little-endian, and so is every machine that this library is built for: arrays are copied as they are.
static_assert(std::endian::native == std::endian::little);

namespace {

constexpr int kDataLoss = 15;

template <class T>
void append_array(std::vector<T>& out, const std::string& bytes, const v1::ContactChunk& chunk, uint64_t before,
                  const char* field) {
  if (bytes.empty() && out.empty()) return;
  if (bytes.size() != chunk.count() * sizeof(T) || out.size() != before)
    throw Error(kDataLoss, std::string("contacts.") + field + " has " + std::to_string(bytes.size()) + " bytes for " +
                               std::to_string(chunk.count()) + " contacts; it needs " +
                               std::to_string(chunk.count() * sizeof(T)));
  out.resize(out.size() + chunk.count());
  std::memcpy(out.data() + before, bytes.data(), bytes.size());
}

}  // namespace

void append(Contacts& contacts, const v1::ContactChunk& chunk) {
  const uint64_t before = contacts.count;
  append_array(contacts.elements, chunk.elements(), chunk, before, "elements");
  append_array(contacts.stencils, chunk.stencils(), chunk, before, "stencils");
  append_array(contacts.toi, chunk.toi(), chunk, before, "toi");
  append_array(contacts.distance, chunk.distance(), chunk, before, "distance");
  append_array(contacts.weights, chunk.weights(), chunk, before, "weights");
  append_array(contacts.flags, chunk.flags(), chunk, before, "flags");
  contacts.count += chunk.count();
}

}  // namespace collided::client
