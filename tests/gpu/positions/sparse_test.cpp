// Sparse updates: the answers of whole ones, bad indices refused, and the right positions after frames that failed.

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

struct Setting {
  const char* name;
  Mode mode;
  Scalar scalar;
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

/// Two scenes that move alike: one gets sparse updates, the other whole ones.
class Twins {
 public:
  Twins(const Setting& setting, uint64_t budget = 0) : setting_(setting), case_(two_meshes()), now_(case_.end) {
    SceneSpec spec = spec_for(case_, settings(setting.mode, Accuracy::kFast, setting.scalar, 0x1p-6));
    whole_ = Detector::create(spec);
    spec.memory_budget = budget;
    sparse_ = Detector::create(spec);
    const Frame first(case_, setting.mode, setting.scalar);
    EXPECT_TRUE(same_contacts(whole_->detect(first.input()), sparse_->detect(first.input())));
  }
  static Case two_meshes() {
    Case c = soup(90, 300, 1, 0.2, 0.1);
    const Case second = soup(91, 200, 1, 0.2, 0.1);
    add_mesh(c, second.meshes[0].triangles, second.start[0], second.end[0]);
    return c;
  }

  /// Every `stride`th vertex of each mesh moves; also where it starts from, if asked for.
  void move(uint32_t stride, bool moves_start, bool by_slot = false) {
    std::vector<OwnedUpdate> sparse, whole;
    for (uint32_t mesh = 0; mesh < 2; ++mesh) {
      sparse.push_back(sparse_update(mesh, stride, moves_start));
      whole.push_back({mesh, false, {}, {}, pack(next_, setting_.scalar)});
      if (setting_.mode == Mode::kCcd) whole.back().start = pack(start_, setting_.scalar);
      now_[mesh] = next_;
    }
    const FrameResult expected = whole_->detect(frame_of(whole));
    FrameInput input = frame_of(sparse);
    if (by_slot) input = sent(sparse_->make_slot(), input.updates);
    EXPECT_TRUE(same_contacts(expected, sparse_->detect(input))) << stride;
    EXPECT_GT(expected.vertex_triangle.size() + expected.edge_edge.size(), 0u) << "there is nothing to compare";
  }

  /// Of the positions that come next; start_ and next_ are those of all vertices then.
  OwnedUpdate sparse_update(uint32_t mesh, uint32_t stride, bool moves_start) {
    start_ = next_ = now_[mesh];
    std::vector<uint32_t> indices;
    Positions start, end;
    for (uint32_t v = stride - 1; v < next_.size(); v += stride) {
      indices.push_back(v);
      if (moves_start) start_[v][v % 3] -= 0.03125;
      next_[v][stride % 3] += 0.0625 * (v % 5 - 2.0);
      start.push_back(start_[v]);
      end.push_back(next_[v]);
    }
    OwnedUpdate update{mesh, true, bytes_of(indices), {}, pack(end, setting_.scalar)};
    if (moves_start) update.start = pack(start, setting_.scalar);
    return update;
  }

  Detector& sparse() { return *sparse_; }
  const Case& scene() const { return case_; }

 private:
  Setting setting_;
  Case case_;
  std::vector<Positions> now_;
  Positions start_, next_;
  std::unique_ptr<Detector> whole_, sparse_;
};

class Sparse : public OnBackend<::testing::TestWithParam<Setting>> {
 protected:
  bool is_ccd() const { return GetParam().mode == Mode::kCcd; }
  /// How often each frame asks at least whether it is given up: between stages on CPU cores, less often on a GPU.
  static int asked_in_a_frame() {
    Twins twins(GetParam());
    int least = std::numeric_limits<int>::max();
    for (const uint32_t stride : {2u, 5u, 5u, 5u, 5u}) {
      const std::vector<OwnedUpdate> updates{twins.sparse_update(0, stride, false)};
      FrameInput frame = frame_of(updates);
      int asked = 0;
      frame.cancelled = [&] { return ++asked < 0; };
      twins.sparse().detect(frame);
      least = std::min(least, asked);
    }
    return least;
  }
};

TEST_P(Sparse, EqualsWhole) {
  Twins twins(GetParam());
  for (const uint32_t stride : {1u, 2u, 7u, 50u, 899u, 3u}) twins.move(stride, false);
  for (const uint32_t stride : {1u, 2u, 7u, 50u, 899u, 3u}) twins.move(stride, is_ccd());
}

TEST_P(Sparse, EqualsWholeBySlots) {
  Twins twins(GetParam());
  for (const uint32_t stride : {2u, 5u, 600u}) twins.move(stride, is_ccd() && stride != 5, true);
}

TEST_P(Sparse, NoIndicesMoveNothing) {
  Twins twins(GetParam());
  twins.move(100'000, false);
  twins.move(2, false);
  twins.move(100'000, false);
}

TEST_P(Sparse, IsRefusedBeforeAMeshHasPositions) {
  Twins twins(GetParam());
  auto fresh =
      Detector::create(spec_for(twins.scene(), settings(GetParam().mode, Accuracy::kFast, GetParam().scalar, 0x1p-6)));
  const std::vector<OwnedUpdate> updates{twins.sparse_update(0, 1, false), twins.sparse_update(1, 1, false)};
  EXPECT_EQ("updates[0].indices", refused_field([&] { fresh->detect(frame_of(updates)); }));
}

TEST_P(Sparse, BadIndicesAreRefusedAndHarmNothing) {
  Twins twins(GetParam());
  twins.move(3, false);
  const OwnedUpdate good = twins.sparse_update(0, 300, false);  // vertices 299, 599, 899
  const std::vector<std::vector<uint32_t>> all_bad{{299, 298, 899},
                                                   {599, 299, 899},
                                                   {299, 299, 899},
                                                   {299, 599, 900},
                                                   {~0u, 599, 899},
                                                   {299, 599, ~0u},
                                                   {0x80000000u, 0x80000001u, ~0u}};
  for (const std::vector<uint32_t>& bad : all_bad) {
    OwnedUpdate update = good;
    update.indices = bytes_of(bad);
    const std::vector<OwnedUpdate> updates{twins.sparse_update(1, 2, false), update};
    EXPECT_EQ("updates[1].indices", refused_field([&] { twins.sparse().detect(frame_of(updates)); }))
        << ::testing::PrintToString(bad);
  }
  twins.move(4, false);
}

TEST_P(Sparse, NumbersOfIndicesAreRefused) {
  Twins twins(GetParam());
  const auto refuses = [&](const OwnedUpdate& update, const char* field) {
    EXPECT_EQ(field, refused_field([&] { twins.sparse().detect(frame_of({update})); }));
  };
  const OwnedUpdate good = twins.sparse_update(0, 3, false);
  OwnedUpdate bad = good;
  bad.indices.pop_back();
  refuses(bad, "updates[0].indices");  // cut off within a number
  bad = good;
  bad.indices.resize(bad.indices.size() - 4);
  refuses(bad, "updates[0].end");  // more positions than indices
  bad = good;
  bad.is_sparse = false;
  refuses(bad, "updates[0].indices");
  bad.indices.clear();
  refuses(bad, "updates[0].end");
  bad = good;
  bad.indices = bytes_of(std::vector<uint32_t>(901));
  refuses(bad, "updates[0].indices");  // more than the mesh has vertices
  twins.move(4, false);
}

TEST_P(Sparse, FollowsTheLastFrameThatSucceeded) {
  Twins twins(GetParam());
  twins.move(2, false);
  const int asked_in_all = asked_in_a_frame();
  for (int asked_before = 0; asked_before < std::min(4, asked_in_all); ++asked_before) {
    const std::vector<OwnedUpdate> updates{twins.sparse_update(0, 1, false)};
    FrameInput cancelled = frame_of(updates);
    int asked = 0;
    cancelled.cancelled = [&] { return asked++ == asked_before; };
    EXPECT_THROW(twins.sparse().detect(cancelled), Cancelled);
    twins.move(5, false);
  }
  OwnedUpdate broken = twins.sparse_update(1, 7, false);
  const Positions nowhere{{0, std::nan(""), 0}};
  const std::vector<std::byte> nan = pack(nowhere, GetParam().scalar);
  std::copy(nan.begin(), nan.end(), broken.end.end() - static_cast<std::ptrdiff_t>(nan.size()));
  EXPECT_EQ("updates[0].end", refused_field([&] { twins.sparse().detect(frame_of({broken})); }));
  twins.move(3, is_ccd());
}

TEST_P(Sparse, FollowsAFrameThatRanOutOfMemory) {
  Twins unbounded(GetParam());
  uint64_t bytes = 2u << 20;
  for (const MemoryPart& part : unbounded.sparse().memory()) bytes += part.bytes;
  Twins twins(GetParam(), bytes);
  Case dense = twins.scene();  // all triangles on one spot
  for (std::vector<Positions>* positions : {&dense.start, &dense.end})
    for (Positions& mesh : *positions)
      for (size_t v = 0; v < mesh.size(); ++v)
        mesh[v] = {0.1 * (v % 3), 0.1 * (v % 2), 1e-3 * static_cast<double>(v % 97)};
  const Frame frame(dense, GetParam().mode, GetParam().scalar);
  EXPECT_THROW(twins.sparse().detect(frame.input()), ResourceExhausted);
  twins.move(3, false);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Sparse,
                         ::testing::Values(Setting{"CcdF32", Mode::kCcd, Scalar::kF32},
                                           Setting{"CcdF64", Mode::kCcd, Scalar::kF64},
                                           Setting{"DcdF32", Mode::kDcd, Scalar::kF32},
                                           Setting{"DcdF64", Mode::kDcd, Scalar::kF64}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace collided::test
