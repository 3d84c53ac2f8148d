// States of pairs of meshes as a daemon may send them.
#include "client/cpp/mesh_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "client/cpp/error.hpp"

namespace collided::client {
namespace {

constexpr SceneSize kSize{.vertices = 12, .elements = 4, .meshes = 3};

template <class T>
std::string packed(const std::vector<T>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)};
}

v1::MeshPairs two_pairs() {
  v1::MeshPairs message;
  message.set_meshes(packed<uint32_t>({0, 1, 1, 2}));
  message.set_states(packed<uint8_t>({v1::MESH_PAIR_STATE_TOUCHING, v1::MESH_PAIR_STATE_FIRST_INSIDE}));
  message.set_inside(packed<uint32_t>({0, 0, 4, 0}));
  message.set_deepest(packed<uint32_t>({MeshPair::kNoVertex, 5}));
  message.set_depths(packed<double>({0, 0.25}));
  return message;
}

TEST(MeshPairs, AreAppended) {
  std::vector<MeshPair> pairs;
  append(pairs, two_pairs(), kSize);
  v1::MeshPairs last = two_pairs();
  last.set_meshes(packed<uint32_t>({1, 3, 2, 3}));
  append(pairs, last, {});
  ASSERT_EQ(pairs.size(), 4u);
  EXPECT_EQ(pairs[0].state, v1::MESH_PAIR_STATE_TOUCHING);
  EXPECT_EQ(pairs[0].deepest, MeshPair::kNoVertex);
  const MeshPair& inside = pairs[1];
  EXPECT_EQ(std::pair(inside.first, inside.second), std::pair(1u, 2u));
  EXPECT_EQ(inside.state, v1::MESH_PAIR_STATE_FIRST_INSIDE);
  EXPECT_EQ(std::pair(inside.first_inside, inside.second_inside), std::pair(4u, 0u));
  EXPECT_EQ(inside.deepest, 5u);
  EXPECT_EQ(inside.depth, 0.25);
  EXPECT_EQ(pairs[3].second, 3u);
}

TEST(MeshPairs, RefuseWhatNoSceneHas) {
  using Spoil = std::function<void(v1::MeshPairs&)>;
  const std::pair<const char*, Spoil> cases[] = {
      {"states is empty", [](auto& m) { m = {}; }},
      {"meshes has 15 bytes for 2 pairs; it needs 16", [](auto& m) { m.mutable_meshes()->pop_back(); }},
      {"inside has 0 bytes", [](auto& m) { m.clear_inside(); }},
      {"deepest has 9 bytes", [](auto& m) { m.mutable_deepest()->push_back(0); }},
      {"depths has 0 bytes", [](auto& m) { m.clear_depths(); }},
      {"meshes has 1 and 1; the first must be below the second",
       [](auto& m) {
         m.set_meshes(packed<uint32_t>({0, 1, 1, 1}));
       }},
      {"meshes has 3; it must be below 3",
       [](auto& m) {
         m.set_meshes(packed<uint32_t>({0, 1, 1, 3}));
       }},
      {"meshes names 0 and 1 after 0 and 1",
       [](auto& m) {
         m.set_meshes(packed<uint32_t>({0, 1, 0, 1}));
       }},
      {"states has 0",
       [](auto& m) {
         m.set_states(packed<uint8_t>({1, 0}));
       }},
      {"states has 200",
       [](auto& m) {
         m.set_states(packed<uint8_t>({200, 1}));
       }},
      {"inside has 13; it must be below 13",
       [](auto& m) {
         m.set_inside(packed<uint32_t>({0, 13, 0, 0}));
       }},
      {"deepest has 12; it must be below 12",
       [](auto& m) {
         m.set_deepest(packed<uint32_t>({12, 0}));
       }},
      {"depths has -1",
       [](auto& m) {
         m.set_depths(packed<double>({0, -1}));
       }},
      {"depths has nan", [](auto& m) {
         m.set_depths(packed<double>({std::nan(""), 0}));
       }}};
  for (const auto& [what, spoil] : cases) {
    v1::MeshPairs message = two_pairs();
    spoil(message);
    std::vector<MeshPair> pairs;
    try {
      append(pairs, message, kSize);
      ADD_FAILURE() << what;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), 15);
      EXPECT_TRUE(e.message().starts_with("pairs." + std::string(what))) << e.message();
    }
  }
}

TEST(VerticesInSolids, HaveDistancesBelowZero) {
  v1::ContactChunk chunk;
  chunk.set_count(1);
  const auto refused = [&](v1::ContactKind kind, double distance) {
    chunk.set_kind(kind);
    chunk.set_distance(packed<double>({distance}));
    Contacts contacts;
    try {
      append(contacts, chunk);
      return std::string();
    } catch (const Error& e) {
      return e.message();
    }
  };
  EXPECT_EQ(refused(v1::CONTACT_KIND_VERTEX_SOLID, -0.5), "");
  EXPECT_EQ(refused(v1::CONTACT_KIND_VERTEX_SOLID, 0.5), "contacts.distance has 0.500000; it must be 0 or less");
  EXPECT_EQ(refused(v1::CONTACT_KIND_VERTEX_SOLID, std::nan("")), "contacts.distance has nan; it must be 0 or less");
  EXPECT_EQ(refused(v1::CONTACT_KIND_VERTEX_TRIANGLE, 0.5), "");
  EXPECT_EQ(refused(v1::CONTACT_KIND_VERTEX_TRIANGLE, -0.5), "contacts.distance has -0.500000; it must be 0 or more");
}

TEST(VerticesInSolids, NameAVertexAndAnElement) {
  Contacts contacts;
  contacts.count = 1;
  contacts.elements = {{11, 3}};
  EXPECT_NO_THROW(check_ids(v1::CONTACT_KIND_VERTEX_SOLID, contacts, 0, kSize));
  for (const std::array<uint32_t, 2> bad : {std::array{12u, 3u}, std::array{11u, 4u}}) {
    contacts.elements = {bad};
    EXPECT_THROW(check_ids(v1::CONTACT_KIND_VERTEX_SOLID, contacts, 0, kSize), Error);
  }
}

}  // namespace
}  // namespace collided::client
