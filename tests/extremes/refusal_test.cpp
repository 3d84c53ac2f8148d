// NaN, infinity and numbers past the limit are refused by name, and the scene answers the next frame as if nothing had
// happened; the largest allowed numbers are accepted.

#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/verdicts/verdict_score_checks.hpp"

namespace collided::test {
namespace {

constexpr size_t kVertex = 41, kAxis = 1;

// A number that cannot be a coordinate, and how the message writes it.
struct Bad {
  double value;
  std::string text;
};

double largest(Scalar scalar) {
  return scalar == Scalar::kF32 ? static_cast<double>(std::numeric_limits<float>::max() / 8)
                                : std::numeric_limits<double>::max() / 8;
}

std::vector<Bad> bad_numbers(Scalar scalar) {
  const double limit = largest(scalar);
  const double past = scalar == Scalar::kF32 ? static_cast<double>(std::nextafter(static_cast<float>(limit), HUGE_VALF))
                                             : std::nextafter(limit, HUGE_VAL);
  std::ostringstream text;
  text.precision(17);
  text << (scalar == Scalar::kF32 ? static_cast<float>(past) : past);
  return {{std::nan(""), "nan"}, {HUGE_VAL, "inf"}, {-HUGE_VAL, "-inf"}, {past, text.str()}, {-past, "-" + text.str()}};
}

Case scene() {
  Case c = soup(60, 200, 1, 0.2, 0.1);
  const Case other = soup(61, 100, 1, 0.3, 0.2);
  add_mesh(c, other.meshes[0].triangles, other.start[0], other.end[0]);
  return c;
}

class Refusals : public OnBackend<::testing::TestWithParam<std::tuple<Scalar, Accuracy>>> {
 protected:
  static SceneSpec spec() {
    return spec_for(scene(), settings(Mode::kCcd, std::get<1>(GetParam()), std::get<0>(GetParam())));
  }
  static Frame frame(const Case& c) { return Frame(c, Mode::kCcd, std::get<0>(GetParam())); }

  // The scene refuses the frame, names update, vertex and value, and then answers a good frame.
  static void expect_refused(Detector& detector, const Case& bad, const std::string& field, const Bad& number) {
    const Frame refused = frame(bad);
    try {
      detector.detect(refused.input());
      ADD_FAILURE() << number.text << " was taken";
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.field(), field);
      const std::string what = e.what();
      for (const std::string& part : {field, "vertex " + std::to_string(kVertex), "coordinate y is " + number.text})
        EXPECT_NE(what.find(part), std::string::npos) << what;
    }
    const Frame good = frame(scene());
    const FrameResult after = detector.detect(good.input());
    EXPECT_TRUE(same_contacts(after, Detector::create(spec())->detect(good.input()))) << number.text;
  }
};

TEST_P(Refusals, NameTheUpdateTheVertexAndTheValue) {
  const std::unique_ptr<Detector> detector = Detector::create(spec());
  for (const Bad& number : bad_numbers(std::get<0>(GetParam()))) {
    Case bad = scene();
    bad.end[1][kVertex][kAxis] = number.value;
    expect_refused(*detector, bad, "updates[1].end", number);
    bad = scene();
    bad.start[0][kVertex][kAxis] = number.value;
    expect_refused(*detector, bad, "updates[0].start", number);
  }
}

// Few triangles: EXACT meets numbers of thousands of bits here.
TEST_P(Refusals, TheLargestNumbersAreTaken) {
  Case c = soup(62, 20, 1, 0.2, 0.1);
  const double limit = largest(std::get<0>(GetParam()));
  c.start[0][kVertex] = {limit, -limit, limit};
  c.end[0][kVertex] = {-limit, limit, 0};
  const auto [scalar, accuracy] = GetParam();
  EXPECT_NO_THROW(run_case(c, settings(Mode::kCcd, accuracy, scalar)));
}

INSTANTIATE_TEST_SUITE_P(
    Levels, Refusals,
    ::testing::Combine(::testing::Values(Scalar::kF32, Scalar::kF64),
                       ::testing::Values(Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact)),
    [](const auto& info) { return name_of(std::get<0>(info.param)) + "_" + name_of(std::get<1>(info.param)); });

}  // namespace
}  // namespace collided::test
