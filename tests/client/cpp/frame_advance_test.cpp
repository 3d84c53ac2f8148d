// A client takes or refuses what an answer says of an advance, and moves positions and scenes as far.

#include "client/cpp/frame_advance.hpp"

#include <grpcpp/support/status_code_enum.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <random>

#include "client/cpp/frame_stream.hpp"
#include "client/cpp/positions.hpp"
#include "client/cpp/session/scene_memory.hpp"
#include "client/cpp/transport/frame_transport.hpp"
#include "gpu/positions/pose.hpp"

namespace collided::client {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr auto kAllOrOne = v1::ADVANCE_MODE_ALL_OR_ONE, kPerMesh = v1::ADVANCE_MODE_PER_MESH,
               kPerVertex = v1::ADVANCE_MODE_PER_VERTEX;

template <class T>
std::string packed(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

v1::ShortenedWays ways_of(const std::vector<uint32_t>& ids, const std::vector<double>& fractions) {
  v1::ShortenedWays ways;
  ways.set_ids(packed(ids));
  ways.set_fractions(packed(fractions));
  return ways;
}

template <class Call>
Error error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return {0, ""};
}

TEST(FrameAdvance, OfSeveralMessagesIsJoined) {
  FrameAdvance advance;
  append(advance, ways_of({2, 5}, {0.5, 0}), 10);
  append(advance, ways_of({9}, {0.75}), 10);
  EXPECT_EQ(advance.ids, (std::vector<uint32_t>{2, 5, 9}));
  EXPECT_EQ(advance.fractions, (std::vector<double>{0.5, 0, 0.75}));
}

TEST(FrameAdvance, RefusesWhatNoDaemonSays) {
  v1::ShortenedWays odd = ways_of({1}, {0.5}), cut = odd;
  odd.mutable_ids()->push_back('x');
  cut.mutable_fractions()->pop_back();
  const v1::ShortenedWays bad[] = {odd,
                                   cut,
                                   ways_of({}, {}),
                                   ways_of({}, {0.5}),
                                   ways_of({1, 2}, {0.5}),
                                   ways_of({1}, {0.5, 0.5}),
                                   ways_of({1, 1}, {0.5, 0.5}),
                                   ways_of({2, 1}, {0.5, 0.5}),
                                   ways_of({7}, {0.5}),
                                   ways_of({~uint32_t{0}}, {0.5}),
                                   ways_of({1}, {1}),
                                   ways_of({1}, {-0.5}),
                                   ways_of({1}, {kNan})};
  for (const v1::ShortenedWays& ways : bad) {
    FrameAdvance advance;
    const Error error = error_of([&] { append(advance, ways, 7); });
    EXPECT_EQ(error.code(), grpc::DATA_LOSS) << ways.ShortDebugString();
    EXPECT_EQ(error.message().rfind("shortened.", 0), 0u) << error.message();
  }
  FrameAdvance advance;
  append(advance, ways_of({3}, {0.5}), 7);
  EXPECT_EQ(error_of([&] { append(advance, ways_of({3}, {0.5}), 7); }).message(),
            "shortened.ids names 3 after 3; it must ascend");
}

TEST(FrameAdvance, TellsHowFarAVertexAndABodyWent) {
  const FrameAdvance all{kAllOrOne, 0.25, {}, {}};
  EXPECT_EQ(all.of_vertex(1, 5), 0.25);
  const FrameAdvance meshes{kPerMesh, 0.25, {1, 3}, {0.25, 0.5}};
  EXPECT_EQ(meshes.of_vertex(0, 1), 1);
  EXPECT_EQ(meshes.of_vertex(1, 100), 0.25);
  EXPECT_EQ(meshes.of_body(2, 3, 10), 1);
  EXPECT_EQ(meshes.of_body(3, 1, 10), 0.5);
  const FrameAdvance vertices{kPerVertex, 0.25, {1, 30, 31, ~uint32_t{0}}, {0.25, 0.5, 0.5, 0}};
  EXPECT_EQ(vertices.of_vertex(0, 0), 1);
  EXPECT_EQ(vertices.of_vertex(0, 1), 0.25);
  EXPECT_EQ(vertices.of_vertex(0, ~uint32_t{0}), 0);
  EXPECT_EQ(vertices.of_body(0, 2, 28), 1);
  EXPECT_EQ(vertices.of_body(0, 29, 3), 0.5);
  EXPECT_EQ(vertices.of_body(0, 32, 100), 1);
}

// Compares with vertices that are moved one at a time.
template <class Real>
void expect_each_alone(const FrameAdvance& advance, uint32_t mesh, uint32_t first_vertex) {
  constexpr size_t kVertices = 50;
  std::mt19937 bits(7);
  std::uniform_real_distribution<Real> anywhere(-100, 100);
  std::vector<Real> x(3 * kVertices), target(x.size());
  for (size_t i = 0; i < x.size(); ++i) x[i] = anywhere(bits), target[i] = anywhere(bits);
  std::vector<Real> expected = x;
  for (size_t i = 0; i < kVertices; ++i)
    move_along(std::span(expected).subspan(3 * i, 3), std::span<const Real>(target).subspan(3 * i, 3),
               advance.of_vertex(mesh, first_vertex + static_cast<uint32_t>(i)));
  move_along(std::span(x), std::span<const Real>(target), advance, mesh, first_vertex);
  EXPECT_EQ(x, expected);
  EXPECT_EQ(x != target, advance.of_body(mesh, first_vertex, kVertices) < 1);
}

TEST(MoveAlong, MovesEachVertexItsOwnFraction) {
  FrameAdvance vertices{kPerVertex, 0, {0, 6, 7, 8, 30, 55, 56, 57, 1000}, {}};
  for (size_t i = 0; i < vertices.ids.size(); ++i) vertices.fractions.push_back(static_cast<double>(i) / 9);
  for (const uint32_t first_vertex : {0u, 6u, 7u, 9u, 56u, 57u, 58u, 951u, 1001u}) {
    expect_each_alone<float>(vertices, 0, first_vertex);
    expect_each_alone<double>(vertices, 0, first_vertex);
  }
  const FrameAdvance meshes{kPerMesh, 0.3, {1}, {0.3}}, all{kAllOrOne, 0.3, {}, {}};
  for (const uint32_t mesh : {0u, 1u, 2u}) {
    expect_each_alone<float>(meshes, mesh, 4);
    expect_each_alone<double>(all, mesh, 4);
  }
}

TEST(MoveAlong, RefusesLengthsThatAreNoPositions) {
  const FrameAdvance vertices{kPerVertex, 0, {0}, {0.5}};
  std::vector<double> x(6);
  const std::vector<double> target(6);
  const auto move = [&](size_t from, size_t to) {
    move_along(std::span(x).first(from), std::span(target).first(to), vertices, 0, 0);
  };
  EXPECT_EQ(error_of([&] { move(6, 3); }).message(), "target has 3 coordinates, positions have 6");
  EXPECT_EQ(error_of([&] { move(5, 5); }).code(), grpc::INVALID_ARGUMENT);
}

/// A turn about an axis of unit length, by this much, and a translation.
RigidMatrix turned(const std::array<double, 3>& n, double angle, const std::array<double, 3>& translation) {
  const double c = std::cos(angle), s = std::sin(angle), v = 1 - c;
  return {c + n[0] * n[0] * v,        n[0] * n[1] * v - n[2] * s, n[0] * n[2] * v + n[1] * s, translation[0],
          n[1] * n[0] * v + n[2] * s, c + n[1] * n[1] * v,        n[1] * n[2] * v - n[0] * s, translation[1],
          n[2] * n[0] * v - n[1] * s, n[2] * n[1] * v + n[0] * s, c + n[2] * n[2] * v,        translation[2]};
}

/// Turns by this much from one pose to the next, about any axis.
struct TwoPoses {
  RigidMatrix from, to;

  TwoPoses(std::mt19937& bits, double angle) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> turn(-3, 3);
    const auto axis = [&] {
      std::array<double, 3> n{normal(bits), normal(bits), normal(bits)};
      const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      for (double& x : n) x /= length;
      return n;
    };
    const auto anywhere = [&] {
      std::array<double, 3> t{};
      for (double& x : t) x = normal(bits) * std::pow(10, turn(bits));
      return t;
    };
    from = turned(axis(), turn(bits), anywhere());
    const RigidMatrix by = turned(axis(), angle, {});
    const std::array<double, 3> t = anywhere();
    for (size_t i = 0; i < 3; ++i) {
      for (size_t k = 0; k < 3; ++k)
        to[4 * i + k] = by[4 * i] * from[k] + by[4 * i + 1] * from[4 + k] + by[4 * i + 2] * from[8 + k];
      to[4 * i + 3] = t[i];
    }
  }
};

constexpr double kFractions[] = {0, 1e-300, 1e-9, 1.0 / 3, 0.5, 127.0 / 128, 0.9999999999, 1};

TEST(PoseAlong, HasTheBitsOfTheEngine) {
  std::mt19937 bits(11);
  for (const double angle : {0.0, 1e-12, 1e-4, 0.3, 0.9, 2.0, 3.0})
    for (int i = 0; i < 100; ++i) {
      const TwoPoses poses(bits, angle);
      for (const double fraction : kFractions) {
        const RigidMatrix pose = pose_along(poses.from, poses.to, fraction);
        const Pose expected = collided::pose_along(Pose{poses.from}, Pose{poses.to}, fraction);
        EXPECT_EQ(std::memcmp(pose.data(), expected.rows.data(), sizeof(pose)), 0) << angle << " by " << fraction;
      }
    }
}

TEST(PoseAlong, IsThePoseWhoseTranslationWentThatFarWhereNothingTurns) {
  std::mt19937 bits(13);
  for (int i = 0; i < 100; ++i) {
    TwoPoses poses(bits, 0);
    for (size_t k = 0; k < 12; ++k)
      if (k % 4 < 3) poses.to[k] = poses.from[k];
    for (const double fraction : kFractions) {
      RigidMatrix expected = poses.from;
      for (const size_t k : {3, 7, 11}) move_along(std::span(&expected[k], 1), std::span(&poses.to[k], 1), fraction);
      EXPECT_EQ(pose_along(poses.from, poses.to, fraction), expected) << fraction;
    }
  }
}

TEST(PoseAlong, RefusesWhatIsNoFractionAndNoShorterWayRound) {
  const RigidMatrix rest{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, half{-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 5};
  RigidMatrix infinite = rest, nothing = rest;
  infinite[0] = HUGE_VAL, nothing[5] = kNan;
  for (const double fraction : {-0.1, 1.5, kNan}) {
    const Error error = error_of([&] { pose_along(rest, rest, fraction); });
    EXPECT_EQ(error.code(), grpc::INVALID_ARGUMENT);
    EXPECT_NE(error.message().find("it must be from 0 to 1"), std::string::npos) << error.message();
  }
  for (const RigidMatrix& bad : {half, infinite, nothing}) {
    const Error error = error_of([&] { pose_along(rest, bad, 0.5); });
    EXPECT_EQ(error.code(), grpc::INVALID_ARGUMENT);
    EXPECT_NE(error.message().find("half a turn apart"), std::string::npos) << error.message();
  }
  EXPECT_EQ(pose_along(rest, half, 1), half);
  EXPECT_EQ(pose_along(half, rest, 0), half);
}

/// A daemon's messages to the one frame that a stream sends.
class ScriptedAnswer final : public FrameTransport {
 public:
  ScriptedAnswer(v1::StreamFramesResponse opened, std::deque<v1::StreamFramesResponse> answer)
      : opened_(std::move(opened)), answer_(std::move(answer)) {}

  bool open(const v1::OpenStream&) override { return true; }
  bool send(const v1::Frame&, std::span<const FrameUpdate>) override { return is_sent_ = true; }
  Arrival read(v1::StreamFramesResponse& response, Time) override {
    if (is_cancelled_) return Arrival::kEnd;
    if (!is_opened_) return is_opened_ = true, response = opened_, Arrival::kMessage;
    if (!is_sent_) return Arrival::kNothing;
    if (answer_.empty()) return Arrival::kEnd;
    response = std::move(answer_.front());
    answer_.pop_front();
    return Arrival::kMessage;
  }
  std::span<const std::byte> shared(const v1::SharedRange&) const override { return {}; }
  void half_close() override {}
  void cancel() override { is_cancelled_ = true; }
  std::optional<Error> finish() override { return {}; }

 private:
  const v1::StreamFramesResponse opened_;
  std::deque<v1::StreamFramesResponse> answer_;
  bool is_opened_ = false;
  std::atomic<bool> is_sent_ = false, is_cancelled_ = false;
};

/// Takes answers, in a scene of a mesh of three vertices and one of four.
class FrameAnswers : public testing::Test {
 protected:
  FrameAnswers() { done.set_advanced(0.5), done.set_way(0.75); }

  FrameOutput taken(const FrameOptions& options) {
    v1::StreamFramesResponse opened;
    opened.mutable_opened()->set_window(1);
    for (const uint32_t vertices : {3, 4}) {
      v1::MeshSpec& mesh = *opened.mutable_opened()->mutable_scene()->mutable_spec()->add_meshes();
      mesh.set_vertex_count(vertices), mesh.set_triangle_count(1);
    }
    std::deque<v1::StreamFramesResponse> messages;
    for (const v1::ShortenedWays& ways : before) *messages.emplace_back().mutable_shortened() = ways;
    for (const v1::ContactChunk& chunk : limits) *messages.emplace_back().mutable_limits() = chunk;
    *messages.emplace_back().mutable_done() = done;
    for (auto& message : messages) message.set_frame_id(1);
    FrameStream stream = FrameStream::open(std::make_unique<ScriptedAnswer>(opened, std::move(messages)), {});
    stream.send(1, {}, options);
    return stream.receive();
  }
  void expect_lost(const std::string& what, const FrameOptions& options) {
    const Error error = error_of([&] { taken(options); });
    EXPECT_EQ(error.code(), grpc::DATA_LOSS) << error.message();
    EXPECT_NE(error.message().find(what), std::string::npos) << error.message();
  }

  const FrameOptions per_mesh{.advance = true, .advance_mode = kPerMesh},
      per_vertex{.advance = true, .advance_mode = kPerVertex};
  std::vector<v1::ShortenedWays> before;
  std::vector<v1::ContactChunk> limits;
  v1::FrameDone done;
};

/// Limits of a vertex each, at the first triangle.
v1::ContactChunk limits_of(const std::vector<uint32_t>& vertices) {
  v1::ContactChunk chunk;
  chunk.set_kind(v1::CONTACT_KIND_VERTEX_TRIANGLE);
  chunk.set_count(static_cast<uint32_t>(vertices.size()));
  std::vector<uint32_t> elements, stencils;
  for (const uint32_t v : vertices) {
    elements.insert(elements.end(), {v, 0});
    stencils.insert(stencils.end(), {v, 0, 1, 2});
  }
  const size_t n = vertices.size();
  chunk.set_elements(packed(elements)), chunk.set_stencils(packed(stencils));
  chunk.set_toi(packed(std::vector<double>(n, 0.5))), chunk.set_distance(packed(std::vector<double>(n, 0.125)));
  chunk.set_weights(packed(std::vector<double>(2 * n, 0.25))), chunk.set_normals(packed(std::vector<float>(3 * n, 1)));
  chunk.set_flags(std::string(n, '\1'));
  return chunk;
}

TEST_F(FrameAnswers, HaveLimitsOfAllMessages) {
  limits = {limits_of({3, 4}), limits_of({5})};
  *done.add_limits() = limits_of({6});
  const FrameOutput output = taken({.advance = true, .limits = true});
  EXPECT_EQ(output.limits.vertex_triangle.count, 4u);
  EXPECT_EQ(output.limits.vertex_triangle.elements.back(), (std::array<uint32_t, 2>{6, 0}));
  EXPECT_EQ(output.limits.vertex_triangle.distance, std::vector<double>(4, 0.125));
  EXPECT_EQ(output.limits.edge_edge.count, 0u);
  EXPECT_EQ(output.vertex_triangle.count, 0u);
  EXPECT_EQ(output.done.limits_size(), 0);
}

TEST_F(FrameAnswers, HaveLimitsOnlyWhereTheFrameAsksForThemAndAllOfEach) {
  limits = {limits_of({3})};
  expect_lost("limits of a frame that does not ask for them", {.advance = true});
  const FrameOptions asks{.advance = true, .limits = true};
  limits = {limits_of({3}), limits_of({4})};
  limits[1].clear_weights();
  expect_lost("weights", asks);
  limits[0].clear_weights();
  expect_lost("limits has no CONTACT_FIELD_WEIGHTS; it must have all fields", asks);
  for (const auto kind :
       {v1::CONTACT_KIND_TRIANGLE_TRIANGLE, v1::CONTACT_KIND_EDGE_TRIANGLE, v1::CONTACT_KIND_VERTEX_SOLID}) {
    limits = {limits_of({3})};
    limits[0].set_kind(kind);
    expect_lost("limits.kind is " + v1::ContactKind_Name(kind) + ", which limits no way", asks);
  }
  limits = {limits_of({7})};
  expect_lost("names 7; the scene has 7 vertices", asks);
  limits = {};
  *done.add_limits() = limits_of({3});
  expect_lost("limits of a frame that does not ask for them", {.advance = true});
  EXPECT_EQ(taken(asks).limits.vertex_triangle.count, 1u);
}

TEST_F(FrameAnswers, HavePairsOfMeshesOfTheLastMessage) {
  v1::MeshPairs& pairs = *done.mutable_pairs();
  pairs.set_meshes(packed(std::vector<uint32_t>{0, 1})), pairs.set_states("\2");
  pairs.set_inside(packed(std::vector<uint32_t>{3, 0})), pairs.set_deepest(packed(std::vector<uint32_t>{1}));
  pairs.set_depths(packed(std::vector<double>{0.5}));
  const FrameOutput output = taken({.advance = true});
  ASSERT_EQ(output.pairs.size(), 1u);
  EXPECT_EQ(output.pairs[0].state, v1::MESH_PAIR_STATE_OVERLAPPING);
  EXPECT_FALSE(output.done.has_pairs());
  pairs.set_meshes(packed(std::vector<uint32_t>{0, 2}));
  expect_lost("pairs.meshes has 2; it must be below 2", {.advance = true});
}

TEST_F(FrameAnswers, AreJoinedFromAllMessages) {
  before = {ways_of({0, 2}, {0.5, 0.75}), ways_of({3}, {0.875})};
  *done.mutable_shortened() = ways_of({6}, {0});
  const FrameOutput output = taken(per_vertex);
  EXPECT_EQ(output.advance.mode, kPerVertex);
  EXPECT_EQ(output.advance.advanced, 0.5);
  EXPECT_EQ(output.advance.ids, (std::vector<uint32_t>{0, 2, 3, 6}));
  EXPECT_EQ(output.advance.fractions, (std::vector<double>{0.5, 0.75, 0.875, 0}));
  EXPECT_EQ(output.done.way(), 0.75);
  EXPECT_FALSE(output.done.has_shortened());
}

TEST_F(FrameAnswers, HaveIdsOfWhatAdvances) {
  *done.mutable_shortened() = ways_of({1}, {0.5});
  EXPECT_EQ(taken(per_mesh).advance.of_body(1, 3, 4), 0.5);
  *done.mutable_shortened() = ways_of({2}, {0.5});
  EXPECT_EQ(taken(per_vertex).advance.of_vertex(0, 2), 0.5);
  expect_lost("shortened.ids names 2; it must be below 2", per_mesh);
  *done.mutable_shortened() = ways_of({7}, {0.5});
  expect_lost("shortened.ids names 7; it must be below 7", per_vertex);
}

TEST_F(FrameAnswers, HaveNoShortenedWaysUnlessTheFrameAsksForThem) {
  EXPECT_EQ(taken({.advance = true}).advance.of_vertex(1, 5), 0.5);
  *done.mutable_shortened() = ways_of({1}, {0.5});
  const FrameOptions others[] = {{}, {.advance = true}, {.advance = true, .advance_mode = kAllOrOne}};
  for (const FrameOptions& options : others)
    expect_lost("shortened ways of a frame that does not advance per mesh or per vertex", options);
}

TEST_F(FrameAnswers, HaveAWayThatIsAFraction) {
  for (const double way : {kNan, -0.5, 1.5}) {
    done.set_way(way);
    expect_lost("done.way is ", per_vertex);
  }
}

// A scene of a cloth of three vertices, a body of four and another cloth of two.
class SceneMemoryOfAdvances : public testing::Test {
 protected:
  SceneMemoryOfAdvances() {
    spec.set_mode(v1::DETECTION_MODE_CCD);
    spec.set_position_format(v1::POSITION_FORMAT_F64);
  }

  static std::span<const std::byte> bytes_of(const std::vector<double>& positions) {
    return std::as_bytes(std::span(positions));
  }
  static std::vector<double> numbered(size_t vertices, double first) {
    std::vector<double> out(3 * vertices);
    for (double& x : out) x = first++;
    return out;
  }
  void begin(SceneMemory& memory) const {
    const std::vector<double> body = numbered(4, 0);
    memory.apply(OwnedFrame(std::vector<FrameUpdate>{{.mesh = 0, .positions = bytes_of(cloth)},
                                                     {.mesh = 1, .positions = bytes_of(body)},
                                                     {.mesh = 2, .positions = bytes_of(strip)}},
                            {}),
                 {});
  }
  static FrameOutput answer_of(FrameAdvance advance) {
    FrameOutput output;
    output.done.set_advanced(advance.advanced);
    output.advance = std::move(advance);
    return output;
  }
  static void expect_at(const FrameUpdate& update, const std::vector<double>& positions) {
    ASSERT_EQ(update.positions.size(), positions.size() * sizeof(double));
    EXPECT_EQ(std::memcmp(update.positions.data(), positions.data(), update.positions.size()), 0) << update.mesh;
  }
  std::vector<double> between(const std::vector<double>& from, const std::vector<double>& to,
                              const std::vector<double>& fractions) const {
    std::vector<double> out = from;
    for (size_t i = 0; i < fractions.size(); ++i)
      move_along(std::span(out).subspan(3 * i, 3), std::span(to).subspan(3 * i, 3), fractions[i]);
    return out;
  }

  const std::vector<MeshInput> meshes{{.name = "cloth", .vertex_count = 3},
                                      {.name = "body", .vertex_count = 4, .is_rigid = true},
                                      {.name = "strip", .vertex_count = 2}};
  const std::vector<double> cloth = numbered(3, 10), strip = numbered(2, 50);
  const std::vector<double> new_cloth = numbered(3, 20), new_strip = numbered(2, 70);
  const RigidMatrix pose{1, 0, 0, 8, 0, 1, 0, 16, 0, 0, 1, 32};
  v1::SceneSpec spec;
};

TEST_F(SceneMemoryOfAdvances, FollowsEachMesh) {
  SceneMemory memory(spec, meshes);
  begin(memory);
  const std::vector<FrameUpdate> step{{.mesh = 0, .positions = bytes_of(new_cloth)},
                                      {.mesh = 1, .transform = &pose},
                                      {.mesh = 2, .positions = bytes_of(new_strip)}};
  memory.apply(OwnedFrame(step, {.advance = true, .advance_mode = kPerMesh}),
               answer_of({kPerMesh, 0.25, {1, 2}, {0.25, 0.75}}));
  const std::vector<FrameUpdate> now = memory.updates(true);
  ASSERT_EQ(now.size(), 3u);
  expect_at(now[0], new_cloth);
  EXPECT_EQ(*now[1].transform, (RigidMatrix{1, 0, 0, 2, 0, 1, 0, 4, 0, 0, 1, 8}));
  expect_at(now[2], between(strip, new_strip, {0.75, 0.75}));
}

TEST_F(SceneMemoryOfAdvances, FollowsEachVertexAndBodiesAsAWhole) {
  SceneMemory memory(spec, meshes);
  begin(memory);
  const std::vector<FrameUpdate> step{{.mesh = 0, .positions = bytes_of(new_cloth)},
                                      {.mesh = 1, .transform = &pose},
                                      {.mesh = 2, .positions = bytes_of(new_strip)}};
  memory.apply(OwnedFrame(step, {.advance = true, .advance_mode = kPerVertex}),
               answer_of({kPerVertex, 0.125, {1, 3, 4, 5, 6, 8}, {0.125, 0.5, 0.5, 0.5, 0.5, 0.75}}));
  const std::vector<FrameUpdate> now = memory.updates(true);
  ASSERT_EQ(now.size(), 3u);
  expect_at(now[0], between(cloth, new_cloth, {1, 0.125, 1}));
  EXPECT_EQ(*now[1].transform, (RigidMatrix{1, 0, 0, 4, 0, 1, 0, 8, 0, 0, 1, 16}));
  expect_at(now[2], between(strip, new_strip, {1, 0.75}));
}

TEST_F(SceneMemoryOfAdvances, FollowsBodiesThatTurn) {
  const RigidMatrix start = turned({0.6, 0, 0.8}, 0.4, {1, 2, 3}), end = turned({0, 1, 0}, 0.9, {4, -5, 1.0 / 3});
  for (const RigidMatrix* from : {&start, static_cast<const RigidMatrix*>(nullptr)}) {
    SceneMemory memory(spec, meshes);
    begin(memory);
    const FrameUpdate turn{.mesh = 1, .transform = &end, .start_transform = from};
    memory.apply(OwnedFrame(std::span(&turn, 1), {.advance = true, .advance_mode = kPerMesh}),
                 answer_of({kPerMesh, 0.375, {1}, {0.375}}));
    EXPECT_EQ(*memory.updates(true)[1].transform,
              pose_along(from ? start : RigidMatrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, end, 0.375));
  }
}

TEST_F(SceneMemoryOfAdvances, FollowsSomeVerticesFromWhereTheyAreOrBegin) {
  const std::vector<double> start = numbered(2, 30), end = numbered(2, 90);
  const uint32_t indices[] = {0, 2};
  for (const bool has_start : {false, true}) {
    SceneMemory memory(spec, meshes);
    begin(memory);
    const FrameUpdate some{.mesh = 0,
                           .positions = bytes_of(end),
                           .start_positions = has_start ? bytes_of(start) : std::span<const std::byte>(),
                           .indices = std::as_bytes(std::span(indices))};
    memory.apply(OwnedFrame(std::span(&some, 1), {.advance = true, .advance_mode = kPerVertex}),
                 answer_of({kPerVertex, 0.5, {1, 2}, {0.25, 0.5}}));
    const std::vector<double> old = has_start ? start : std::vector<double>{10, 11, 12, 16, 17, 18};
    const std::vector<double> moved = between(old, end, {1, 0.5});
    std::vector<double> expected = cloth;
    std::copy_n(moved.begin(), 3, expected.begin());
    std::copy_n(moved.begin() + 3, 3, expected.begin() + 6);
    expect_at(memory.updates(true)[0], expected);
  }
}

TEST_F(SceneMemoryOfAdvances, RefusesAFrameThatNoDaemonHasApplied) {
  SceneMemory memory(spec, meshes);
  begin(memory);
  const FrameUpdate bad{.mesh = 0, .positions = bytes_of(new_cloth), .start_positions = bytes_of(strip)};
  const Error error = error_of([&] {
    memory.apply(OwnedFrame(std::span(&bad, 1), {.advance = true, .advance_mode = kPerVertex}),
                 answer_of({kPerVertex, 0.5, {1}, {0.5}}));
  });
  EXPECT_EQ(error.code(), grpc::DATA_LOSS) << error.message();
}

}  // namespace
}  // namespace collided::client
