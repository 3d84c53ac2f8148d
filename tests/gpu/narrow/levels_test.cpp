// GUARDED, CERTIFIED and EXACT through whole scenes, against the exact judge.

#include <algorithm>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kLevels[] = {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};

bool is_subset(const std::vector<PairKey>& part, const std::vector<PairKey>& whole) {
  return std::includes(whole.begin(), whole.end(), part.begin(), part.end());
}

// Index of each pair.
std::map<PairKey, size_t> places_of(const ContactSet& contacts) {
  std::map<PairKey, size_t> places;
  for (size_t i = 0; i < contacts.size(); ++i) places[key_of(contacts.elements[i][0], contacts.elements[i][1])] = i;
  return places;
}

void expect_well_formed(const ContactSet& contacts, Mode mode) {
  const std::vector<PairKey> keys = keys_of(contacts);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end(), std::less_equal<>())) << "order, or a pair twice";
  EXPECT_EQ(contacts.toi.size(), mode == Mode::kCcd ? contacts.size() : 0);
  EXPECT_EQ(contacts.distance.size(), contacts.size());
  EXPECT_EQ(contacts.flags.size(), contacts.size());
  for (double toi : contacts.toi) EXPECT_TRUE(toi >= 0 && toi <= 1) << toi;
  for (double distance : contacts.distance) EXPECT_GE(distance, 0);
  for (uint8_t flags : contacts.flags) EXPECT_NE((flags & kFlagCertified) != 0, (flags & kFlagNear) != 0) << int{flags};
}

// What every level promises: nothing missed, nothing late, nothing wrongly certain.
void expect_promises(const ContactSet& contacts, const Truth& truth, Mode mode) {
  expect_well_formed(contacts, mode);
  const std::map<PairKey, size_t> places = places_of(contacts);
  EXPECT_TRUE(is_subset(keys_of(truth), keys_of(contacts))) << "missed";
  for (const auto& [key, place] : places) {
    const auto judged = truth.find(key);
    if (judged == truth.end()) {
      EXPECT_EQ(contacts.flags[place] & kFlagCertified, 0) << "certain, but no contact";
    } else if (mode == Mode::kCcd) {
      EXPECT_LE(mpq_class(contacts.toi[place]), judged->second.upper) << "late";
    }
  }
}

// EXACT: the judge's contacts, all certain, and the judge's word on whether they touch at the start; without thickness
// their times are early by less than 2^-50.
void expect_exact(const ContactSet& contacts, const Truth& truth, Mode mode, double thickness) {
  ASSERT_EQ(keys_of(contacts), keys_of(truth));
  size_t i = 0;
  for (const auto& [key, impact] : truth) {
    const bool is_initial = mode == Mode::kCcd && impact.upper == 0;
    EXPECT_EQ(contacts.flags[i] & ~kFlagSeparating, kFlagCertified | (is_initial ? kFlagInitial : 0));
    if (mode == Mode::kCcd && thickness == 0) {
      EXPECT_GT(mpq_class(contacts.toi[i]) + mpq_class(0x1p-50), impact.lower) << "early";
    }
    ++i;
  }
}

struct Question {
  std::string name;
  Case c;
  Mode mode;
  double thickness;
  size_t least_contacts;    ///< of the judge, so that the case is worth asking
  bool is_lattice = false;  ///< has contacts that only exact arithmetic can decide
};
void PrintTo(const Question& question, std::ostream* out) { *out << question.name; }

std::vector<Question> questions() {
  const Case small = soup(80, 80, 1, 0.3, 0.2), integers = lattice(81, 60, 6);
  return {{"Continuous", small, Mode::kCcd, 0, 20},
          {"ContinuousThick", soup(82, 50, 1, 0.3, 0.1), Mode::kCcd, 0x1p-6, 20},
          {"ContinuousLattice", integers, Mode::kCcd, 0, 200, true},
          {"ContinuousLatticeThick", lattice(83, 24, 6), Mode::kCcd, 1, 100, true},
          {"ContinuousFar", soup(84, 80, 1, 0.3, 0.2, {1e3, -2e3, 4e3}), Mode::kCcd, 0, 20},
          {"Discrete", soup(85, 200, 1, 0.3, 0.1), Mode::kDcd, 0x1p-6, 100},
          {"DiscreteLattice", integers, Mode::kDcd, 1, 200, true},
          {"DiscreteTouching", lattice(86, 150, 10), Mode::kDcd, 0, 100, true},
          {"LooseContinuous", loose_soup(87, 60, 0.5, 0.3, 0.2), Mode::kCcd, 0, 20},
          {"LooseContinuousThick", loose_soup(88, 45, 1, 0.3, 0.2), Mode::kCcd, 0x1p-6, 20},
          {"LooseContinuousLattice", on_integers(loose_soup(89, 60, 4, 4, 4)), Mode::kCcd, 0, 200, true},
          {"LooseContinuousLatticeThick", on_integers(loose_soup(90, 24, 6, 4, 4)), Mode::kCcd, 1, 100, true},
          {"LooseDiscrete", loose_soup(91, 150, 1, 0.3, 0.1), Mode::kDcd, 0x1p-6, 100},
          {"LooseDiscreteLattice", on_integers(loose_soup(92, 60, 6, 4, 4)), Mode::kDcd, 1, 200, true},
          {"LooseDiscreteTouching", on_integers(loose_soup(93, 90, 4, 4, 4)), Mode::kDcd, 0, 100, true}};
}

using LevelsParam = std::tuple<Question, Scalar>;

class Levels : public OnBackend<::testing::TestWithParam<LevelsParam>> {};

TEST_P(Levels, KeepTheirPromises) {
  const auto& [question, scalar] = GetParam();
  const Case c = rounded(question.c, scalar);
  SceneSpec spec = settings(question.mode, Accuracy::kCandidates, scalar, question.thickness);
  const FrameResult candidates = run_case(c, spec);
  const CaseJudge judge(c, question.mode, question.thickness);
  const Truth vt = judge.vertex_triangle(candidates.vertex_triangle.elements);
  const Truth ee = judge.edge_edge(candidates.edge_edge.elements);
  EXPECT_GE(vt.size() + ee.size(), question.least_contacts);
  for (double delta : {0.0, 0x1p-6})  // the second makes near contacts, which have to be told from certain ones
    for (Accuracy accuracy : kLevels) {
      SCOPED_TRACE(level_name(accuracy) + ", delta " + std::to_string(delta));
      spec.accuracy = accuracy;
      spec.delta = delta;
      const FrameResult r = run_case(c, spec);
      expect_promises(r.vertex_triangle, vt, question.mode);
      expect_promises(r.edge_edge, ee, question.mode);
      EXPECT_EQ(r.counts.contacts.vertex_triangle, r.vertex_triangle.size());
      EXPECT_EQ(r.counts.contacts.edge_edge, r.edge_edge.size());
      EXPECT_EQ(r.any_contact, r.vertex_triangle.size() + r.edge_edge.size() > 0);
      if (accuracy != Accuracy::kExact) {
        EXPECT_EQ(r.counts.exact_decisions, 0u);
        continue;
      }
      if (question.is_lattice) {
        EXPECT_GT(r.counts.exact_decisions, 0u);
      }
      expect_exact(r.vertex_triangle, vt, question.mode, question.thickness);
      expect_exact(r.edge_edge, ee, question.mode, question.thickness);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, Levels, ::testing::Combine(::testing::ValuesIn(questions()), ::testing::Values(Scalar::kF32, Scalar::kF64)),
    [](const auto& info) {
      return std::get<0>(info.param).name + (std::get<1>(info.param) == Scalar::kF32 ? "F32" : "F64");
    });

// On scenes too large to judge every candidate: EXACT's contacts are judged and looked for at the other levels.
class LevelsOfScenes : public OnBackend<::testing::TestWithParam<std::tuple<std::string, Scalar>>> {
 protected:
  static constexpr size_t kMaxJudged = 300;

  // Evenly chosen ones of many.
  static std::vector<std::array<uint32_t, 2>> sample(std::span<const std::array<uint32_t, 2>> pairs) {
    const size_t step = pairs.size() / kMaxJudged + 1;
    std::vector<std::array<uint32_t, 2>> some;
    for (size_t i = 0; i < pairs.size(); i += step) some.push_back(pairs[i]);
    return some;
  }

  static void expect_judged(const ContactSet& contacts, const Truth& truth) {
    const std::map<PairKey, size_t> places = places_of(contacts);
    for (const auto& [key, impact] : truth) {
      const auto place = places.find(key);
      ASSERT_TRUE(place != places.end()) << "missed";
      EXPECT_LE(mpq_class(contacts.toi[place->second]), impact.upper) << "late";
    }
  }
};

TEST_P(LevelsOfScenes, HaveEveryExactContactInTime) {
  constexpr double kScale = 0.3;
  const auto& [name, scalar] = GetParam();
  const Case c = rounded(case_of(*scenes::make_scene(name, kScale), 0.8 - 1.0 / 60, 0.8), scalar);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kExact, scalar);
  const FrameResult exact = run_case(c, spec);
  const CaseJudge judge(c, Mode::kCcd, 0);
  const auto vt_pairs = sample(exact.vertex_triangle.elements), ee_pairs = sample(exact.edge_edge.elements);
  const Truth vt = judge.vertex_triangle(vt_pairs), ee = judge.edge_edge(ee_pairs);
  EXPECT_EQ(vt.size(), vt_pairs.size()) << "not all of EXACT are contacts";
  EXPECT_EQ(ee.size(), ee_pairs.size()) << "not all of EXACT are contacts";
  for (Accuracy accuracy : kLevels) {
    SCOPED_TRACE(level_name(accuracy));
    spec.accuracy = accuracy;
    const FrameResult r = run_case(c, spec);
    expect_well_formed(r.vertex_triangle, Mode::kCcd);
    expect_well_formed(r.edge_edge, Mode::kCcd);
    EXPECT_TRUE(is_subset(keys_of(exact.vertex_triangle), keys_of(r.vertex_triangle)));
    EXPECT_TRUE(is_subset(keys_of(exact.edge_edge), keys_of(r.edge_edge)));
    expect_judged(r.vertex_triangle, vt);
    expect_judged(r.edge_edge, ee);
  }
}

INSTANTIATE_TEST_SUITE_P(Procedural, LevelsOfScenes,
                         ::testing::Combine(::testing::ValuesIn(scene_names()),
                                            ::testing::Values(Scalar::kF32, Scalar::kF64)),
                         [](const auto& info) {
                           return std::get<0>(info.param) + (std::get<1>(info.param) == Scalar::kF32 ? "_F32" : "_F64");
                         });

class Delta : public OnBackend<::testing::TestWithParam<Accuracy>> {
 protected:
  Case soup_ = soup(87, 400, 1, 0.2, 0.1);

  FrameResult with(double delta) const {
    SceneSpec spec = settings(Mode::kCcd, GetParam());
    spec.delta = delta;
    return run_case(soup_, spec);
  }

  // Contacts of a larger delta: no fewer, none later.
  static void expect_wider(const ContactSet& wide, const ContactSet& narrow) {
    const std::map<PairKey, size_t> places = places_of(wide);
    for (size_t i = 0; i < narrow.size(); ++i) {
      const auto place = places.find(key_of(narrow.elements[i][0], narrow.elements[i][1]));
      ASSERT_TRUE(place != places.end()) << "lost";
      EXPECT_LE(wide.toi[place->second], narrow.toi[i]);
    }
  }
  // What is reported is that close when it is.
  static void expect_within(const ContactSet& contacts, double delta) {
    EXPECT_LE(*std::max_element(contacts.distance.begin(), contacts.distance.end()), delta);
  }
};

TEST_P(Delta, WidensWhatIsReported) {
  FrameResult narrow = with(0);
  const size_t tightest = narrow.vertex_triangle.size() + narrow.edge_edge.size();
  for (double delta : {1e-4, 1e-3, 1e-2}) {
    SCOPED_TRACE(delta);
    FrameResult wide = with(delta);
    expect_wider(wide.vertex_triangle, narrow.vertex_triangle);
    expect_wider(wide.edge_edge, narrow.edge_edge);
    expect_within(wide.vertex_triangle, 1.5 * delta);
    expect_within(wide.edge_edge, 1.5 * delta);
    narrow = std::move(wide);
  }
  EXPECT_GT(narrow.vertex_triangle.size() + narrow.edge_edge.size(), tightest) << "delta plays no part";
}

INSTANTIATE_TEST_SUITE_P(Levels, Delta, ::testing::Values(Accuracy::kGuarded, Accuracy::kCertified),
                         [](const auto& info) { return level_name(info.param); });

using ExactDelta = OnBackend<>;

TEST_F(ExactDelta, ContactsAreTheSameForAnyDelta) {
  const Case c = soup(87, 200, 1, 0.2, 0.1);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kExact);
  const FrameResult tight = run_case(c, spec);
  EXPECT_GT(tight.vertex_triangle.size() + tight.edge_edge.size(), 10u);
  for (double delta : {1e-6, 1e-3, 0.1}) {
    spec.delta = delta;
    const FrameResult wide = run_case(c, spec);
    EXPECT_EQ(tight.vertex_triangle.elements, wide.vertex_triangle.elements) << delta;
    EXPECT_EQ(tight.edge_edge.elements, wide.edge_edge.elements) << delta;
  }
}

}  // namespace
}  // namespace collided::test
