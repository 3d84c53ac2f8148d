// Text reports: units, digits, separators, and missing values.

#include "client/app/report/text.hpp"

#include <gtest/gtest.h>

#include "client/app/report/contacts.hpp"

namespace collided::cli {
namespace {

TEST(ShownName, HasNothingThatSteersATerminal) { EXPECT_EQ(shown_name("knot\x1b[2J\n\x9b\x7f"), "knot?[2J???"); }

TEST(ReportText, LinesAreAlignedAndNumbersHaveTheirUnits) {
  EXPECT_EQ(report_text({{"scene", {{"triangles", 91872}, {"delta", 0.0}, {"kinds", {"vt", "ee"}}}},
                         {"contact_count", nullptr},
                         {"any_contact", true},
                         {"earliest_toi", 0.4999999999999989},
                         {"step_ms", 0.028902999999999984},
                         {"seconds", 12.34567},
                         {"stage_ms", {{"boxes", 13.677857}, {"bottom_up", 1234.5}}},
                         {"device_bytes", 21860071},
                         {"warnings", Json::array()},
                         {"local_socket", ""}}),
            "scene\n"
            "  triangles  91,872\n"
            "  delta      automatic\n"
            "  kinds      vt, ee\n"
            "contact_count  not counted\n"
            "any_contact    yes\n"
            "earliest_toi   0.5\n"
            "step           0.0289 ms\n"
            "seconds        12.35 s\n"
            "stages\n"
            "  boxes      13.7 ms\n"
            "  bottom_up  1,235 ms\n"
            "device_bytes   21,860,071 bytes\n"
            "warnings       none\n"
            "local_socket   none\n");
  EXPECT_EQ(report_text({{"delta", 1e-6}}), "delta  1e-06\n");
}

client::Contacts contacts(std::vector<double> toi) {
  client::Contacts out;
  out.count = toi.size();
  out.toi = std::move(toi);
  for (uint32_t i = 0; i < out.count; ++i) {
    out.elements.push_back({i, i + 10});
    out.flags.push_back(v1::CONTACT_FLAG_NEAR | v1::CONTACT_FLAG_INITIAL);
  }
  return out;
}

TEST(EarliestContact, IsTheFirstOfTheEarliestTimes) {
  client::FrameOutput output;
  EXPECT_FALSE(earliest_contact(output));
  output.vertex_triangle = contacts({0.5, 0.25, 0.25});
  output.edge_edge = contacts({0.25, 0.75});
  EXPECT_EQ(*earliest_contact(output),
            (Json{{"kind", "vertex_triangle"}, {"elements", {1, 11}}, {"toi", 0.25}, {"flags", {"near", "initial"}}}));
  output.edge_edge.toi[1] = 0.1;
  EXPECT_EQ(earliest_contact(output)->at("kind"), "edge_edge");
  output.edge_edge = output.vertex_triangle = {};
  output.triangle_triangle = contacts({});
  EXPECT_FALSE(earliest_contact(output));
}

TEST(Flags, AreMasks) {
  EXPECT_EQ(flag_words(0).size(), 0u);
  EXPECT_EQ(flag_words(v1::CONTACT_FLAG_CAPPED), (std::vector<std::string_view>{"capped"}));
  EXPECT_EQ(flag_words(15), (std::vector<std::string_view>{"certified", "near", "capped", "initial"}));
  EXPECT_EQ(flag_words(v1::CONTACT_FLAG_CERTIFIED | v1::CONTACT_FLAG_TOUCHING),
            (std::vector<std::string_view>{"certified", "touching"}));
}

TEST(FeatureWords, TellTheClosestFeaturesAndWhatCoversThem) {
  const auto words = [](v1::ContactKind kind, uint8_t features) {
    std::string text;
    for (const std::string_view word : feature_words(kind, features)) text += std::string(word) + " ";
    return text;
  };
  const char* const places[] = {"face", "side_1", "side_2", "side_3", "corner_1", "corner_2", "corner_3", "unknown"};
  for (uint8_t place = 0; place < 8; ++place)
    EXPECT_EQ(words(v1::CONTACT_KIND_VERTEX_TRIANGLE, place), "vertex " + std::string(places[place]) + " ");
  EXPECT_EQ(words(v1::CONTACT_KIND_VERTEX_TRIANGLE, 2 + 32 + 64), "vertex side_2 nearer_at_second same_as_before ");
  EXPECT_EQ(words(v1::CONTACT_KIND_EDGE_EDGE, 0), "inside inside ");
  EXPECT_EQ(words(v1::CONTACT_KIND_EDGE_EDGE, 1 + 8), "end_1 end_2 ");
  EXPECT_EQ(words(v1::CONTACT_KIND_EDGE_EDGE, 2 + 4 + 16), "end_2 end_1 nearer_at_first ");
  EXPECT_EQ(words(v1::CONTACT_KIND_EDGE_TRIANGLE, 0), "");
}

TEST(Covered, AreCountedAndLeftOutWithAllColumns) {
  client::FrameOutput output;
  output.vertex_triangle.count = 3;
  output.vertex_triangle.elements = {{1, 0}, {2, 0}, {3, 0}};
  output.vertex_triangle.flags = {1, 1 | v1::CONTACT_FLAG_COVERED, 1};
  EXPECT_FALSE(count_covered(output));
  output.vertex_triangle.features = {4, 5, 6};
  EXPECT_EQ(count_covered(output), 1u);
  leave_out_covered(output);
  EXPECT_EQ(output.vertex_triangle.count, 2u);
  EXPECT_EQ(output.vertex_triangle.elements, (std::vector<std::array<uint32_t, 2>>{{1, 0}, {3, 0}}));
  EXPECT_EQ(output.vertex_triangle.features, (std::vector<uint8_t>{4, 6}));
  EXPECT_EQ(output.vertex_triangle.flags, (std::vector<uint8_t>{1, 1}));
  EXPECT_TRUE(output.vertex_triangle.weights.empty());
  EXPECT_EQ(count_covered(output), 0u);
}

}  // namespace
}  // namespace collided::cli
