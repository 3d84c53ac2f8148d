// Unpacks and checks states of pairs of meshes.

#include "client/cpp/mesh_pairs.hpp"

#include <cstring>
#include <string>
#include <utility>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

constexpr int kDataLoss = 15;

[[noreturn]] void throw_lost(const std::string& what) { throw Error(kDataLoss, "pairs." + what); }

template <class T>
T number_at(const std::string& bytes, size_t i) {
  T number;
  std::memcpy(&number, bytes.data() + i * sizeof(T), sizeof(T));
  return number;
}

void check_length(const char* field, const std::string& bytes, size_t count, size_t width) {
  if (bytes.size() != count * width)
    throw_lost(std::string(field) + " has " + std::to_string(bytes.size()) + " bytes for " + std::to_string(count) +
               " pairs; it needs " + std::to_string(count * width));
}

void check_below(const char* field, uint32_t number, uint64_t limit) {
  if (limit > 0 && number >= limit)
    throw_lost(std::string(field) + " has " + std::to_string(number) + "; it must be below " + std::to_string(limit));
}

std::string text_of(const MeshPair& pair) { return std::to_string(pair.first) + " and " + std::to_string(pair.second); }

void check(const MeshPair& pair, const SceneSize& size) {
  if (pair.first >= pair.second) throw_lost("meshes has " + text_of(pair) + "; the first must be below the second");
  check_below("meshes", pair.second, size.meshes);
  if (pair.state == v1::MESH_PAIR_STATE_UNSPECIFIED || !v1::MeshPairState_IsValid(pair.state))
    throw_lost("states has " + std::to_string(pair.state) + ", which this client does not know");
  const uint64_t counts = size.vertices == 0 ? 0 : size.vertices + 1;
  for (const uint32_t inside : {pair.first_inside, pair.second_inside}) check_below("inside", inside, counts);
  if (pair.deepest != MeshPair::kNoVertex) check_below("deepest", pair.deepest, size.vertices);
  if (!(pair.depth >= 0)) throw_lost("depths has " + std::to_string(pair.depth) + "; it must be 0 or more");
}

MeshPair pair_at(const v1::MeshPairs& message, size_t i) {
  return {.first = number_at<uint32_t>(message.meshes(), 2 * i),
          .second = number_at<uint32_t>(message.meshes(), 2 * i + 1),
          .state = static_cast<v1::MeshPairState>(number_at<uint8_t>(message.states(), i)),
          .first_inside = number_at<uint32_t>(message.inside(), 2 * i),
          .second_inside = number_at<uint32_t>(message.inside(), 2 * i + 1),
          .deepest = number_at<uint32_t>(message.deepest(), i),
          .depth = number_at<double>(message.depths(), i)};
}

}  // namespace

void append(std::vector<MeshPair>& pairs, const v1::MeshPairs& message, const SceneSize& size) {
  const size_t count = message.states().size();
  if (count == 0) throw_lost("states is empty; a message has 1 pair or more");
  check_length("meshes", message.meshes(), count, 2 * sizeof(uint32_t));
  check_length("inside", message.inside(), count, 2 * sizeof(uint32_t));
  check_length("deepest", message.deepest(), count, sizeof(uint32_t));
  check_length("depths", message.depths(), count, sizeof(double));
  for (size_t i = 0; i < count; ++i) {
    const MeshPair pair = pair_at(message, i);
    check(pair, size);
    if (!pairs.empty() && std::pair(pair.first, pair.second) <= std::pair(pairs.back().first, pairs.back().second))
      throw_lost("meshes names " + text_of(pair) + " after " + text_of(pairs.back()) + "; they must ascend");
    pairs.push_back(pair);
  }
}

}  // namespace collided::client
