// What an answer holds on the host counts in the scene's quota, from before it is there until its last copy is gone.

#include "tests/gpu/backend.hpp"
#include "tests/gpu/counted_quota.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

template <class T>
uint64_t bytes_of(const Column<T>& values) {
  return values.size() * sizeof(T);
}
uint64_t bytes_of(const ContactSet& set) {
  return bytes_of(set.elements) + bytes_of(set.toi) + bytes_of(set.distance) + bytes_of(set.weights) +
         bytes_of(set.flags);
}
uint64_t bytes_of(const FrameResult& r) {
  return bytes_of(r.vertex_triangle) + bytes_of(r.edge_edge) + bytes_of(r.triangle_triangle);
}

uint64_t answer_bytes(const Detector& detector) {
  for (const MemoryPart& part : detector.memory())
    if (part.part == "answers") return part.bytes;
  return 0;
}

class AnswerMemory : public OnBackend<> {
 protected:
  /// Held for answers of so many bytes: with head-room of a quarter, and columns aligned.
  static void expect_held(uint64_t held, uint64_t bytes, uint64_t answers = 1) {
    constexpr uint64_t kColumns = 5, kAlignment = 64;
    EXPECT_GE(held, bytes);
    EXPECT_LE(held, bytes / 4 * 5 + answers * 2 * kColumns * kAlignment);
  }

  std::unique_ptr<Detector> make(SceneSpec spec) {
    spec.memory_quota = quota_;
    return Detector::create(spec_for(case_, spec));
  }
  FrameResult answer(Detector& detector, const SceneSpec& spec, uint64_t beside = 0) {
    const Frame frame(case_, spec.mode, spec.scalar);
    FrameInput input = frame.input();
    input.bytes_beside_contact = beside;
    return detector.detect(input);
  }

  const Case case_ = soup(160, 400, 0.3, 0.2, 0.05);
  const std::shared_ptr<CountedQuota> quota_ = std::make_shared<CountedQuota>();
};

TEST_F(AnswerMemory, CountsWhileAnAnswerLives) {
  for (const Mode mode : {Mode::kCcd, Mode::kDcd})
    for (const Accuracy level : {Accuracy::kCandidates, Accuracy::kCertified}) {
      SceneSpec spec = settings(mode, level, Scalar::kF32, 0.01);
      spec.fields = spec.fields.with(ContactField::kWeights);
      auto detector = make(spec);
      FrameResult result = answer(*detector, spec);
      const uint64_t bytes = bytes_of(result);
      ASSERT_GT(bytes, 1000u);
      expect_held(answer_bytes(*detector), bytes);
      FrameResult copy = result;
      result = {};
      detector = nullptr;
      expect_held(quota_->held(), bytes);  // the scene is gone, a copy is there
      copy = {};
      EXPECT_EQ(quota_->held(), 0u);
    }
}

TEST_F(AnswerMemory, CountsWhatTheCallerHoldsBeside) {
  constexpr uint64_t kBeside = 16;
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32);
  const auto detector = make(spec);
  const FrameResult result = answer(*detector, spec, kBeside);
  const auto plain = make(spec);
  answer(*plain, spec);
  const uint64_t contacts = result.vertex_triangle.size() + result.edge_edge.size();
  expect_held(answer_bytes(*detector), bytes_of(result) + contacts * kBeside);
  EXPECT_GE(answer_bytes(*detector) - answer_bytes(*plain), contacts * kBeside);
}

// Others may have taken the rest of the quota meanwhile.
TEST_F(AnswerMemory, StaysWithTheScene) {
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32);
  const auto detector = make(spec);
  const FrameResult first = answer(*detector, spec);
  { const FrameResult second = answer(*detector, spec); }
  expect_held(answer_bytes(*detector), 2 * bytes_of(first), 2);
  quota_->set_most(quota_->held());
  EXPECT_TRUE(same_contacts(first, answer(*detector, spec)));
  const FrameResult second = answer(*detector, spec);
  EXPECT_THROW(answer(*detector, spec), ResourceExhausted) << "one more than ever before";
}

TEST_F(AnswerMemory, IsAskedForBeforeTheFrameCounts) {
  const SceneSpec spec = settings(Mode::kCcd, Accuracy::kExact, Scalar::kF64);
  const auto detector = make(spec);
  const auto twin = Detector::create(spec_for(case_, spec));
  const Frame frame(case_, spec.mode, spec.scalar);
  const FrameResult kept = detector->detect(frame.input());  // so that the next needs more room
  twin->detect(frame.input());
  Case back = case_;
  std::swap(back.start, back.end);
  const Frame refused(back, spec.mode, spec.scalar);
  quota_->set_most(quota_->held());
  EXPECT_THROW(detector->detect(refused.input()), ResourceExhausted);
  quota_->set_most(~uint64_t{0});
  FrameInput rest = frame.input();
  for (MeshPositions& update : rest.updates) update.start = {};  // from the end of the good frame
  EXPECT_TRUE(same_contacts(twin->detect(rest), detector->detect(rest)));
}

}  // namespace
}  // namespace collided::test
