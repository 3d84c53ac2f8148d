// States of pairs of meshes as messages.
#include "server/convert/mesh_pairs.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace collided::server {
namespace {

template <class T>
std::vector<T> numbers(const std::string& bytes) {
  std::vector<T> out(bytes.size() / sizeof(T));
  std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}

TEST(MeshPairs, ArePacked) {
  const std::vector<MeshPairState> pairs{
      {.first = 0, .second = 1, .state = PairState::kTouching},
      {.first = 0, .second = 2, .state = PairState::kOverlapping, .second_inside = 3, .deepest = 7, .depth = 0.5},
      {.first = 1, .second = 4, .state = PairState::kFirstInside, .first_inside = 8, .deepest = 0, .depth = 4},
      {.first = 2, .second = 3, .state = PairState::kSecondInside, .second_inside = 1, .deepest = 9, .depth = 1e-9}};
  pb::MeshPairs message;
  fill_pairs(pairs, &message);
  EXPECT_EQ(numbers<uint32_t>(message.meshes()), (std::vector<uint32_t>{0, 1, 0, 2, 1, 4, 2, 3}));
  EXPECT_EQ(message.states(), "\1\2\3\4");
  EXPECT_EQ(numbers<uint32_t>(message.inside()), (std::vector<uint32_t>{0, 0, 0, 3, 8, 0, 0, 1}));
  EXPECT_EQ(numbers<uint32_t>(message.deepest()), (std::vector<uint32_t>{4294967295, 7, 0, 9}));
  EXPECT_EQ(numbers<double>(message.depths()), (std::vector<double>{0, 0.5, 4, 1e-9}));
  EXPECT_EQ(array_bytes(pairs), message.meshes().size() + message.states().size() + message.inside().size() +
                                    message.deepest().size() + message.depths().size());
}

TEST(MeshPairs, AreCutInOrder) {
  std::vector<MeshPairState> pairs;
  EXPECT_TRUE(cut_into_chunks(pairs, 100).empty());
  for (uint32_t i = 0; i < 5; ++i) pairs.push_back({.first = i, .second = i + 1});
  for (const size_t max_bytes : {1, 29, 57, 58, 144, 145, 1000}) {
    const size_t most = std::max<size_t>(1, max_bytes / kPairStateBytes);
    uint32_t next = 0;
    for (const MeshPairStates chunk : cut_into_chunks(pairs, max_bytes)) {
      EXPECT_GT(chunk.size(), 0u);
      EXPECT_LE(chunk.size(), most);
      for (const MeshPairState& pair : chunk) EXPECT_EQ(pair.first, next++);
    }
    EXPECT_EQ(next, 5u);
  }
}

}  // namespace
}  // namespace collided::server
