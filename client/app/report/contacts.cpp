// One contact for people and as JSON.

#include "client/app/report/contacts.hpp"

#include <algorithm>
#include <limits>

namespace collided::cli {

namespace {

constexpr std::pair<v1::ContactFlag, std::string_view> kFlagWords[] = {
    {v1::CONTACT_FLAG_CERTIFIED, "certified"},   {v1::CONTACT_FLAG_NEAR, "near"},
    {v1::CONTACT_FLAG_CAPPED, "capped"},         {v1::CONTACT_FLAG_INITIAL, "initial"},
    {v1::CONTACT_FLAG_SEPARATING, "separating"}, {v1::CONTACT_FLAG_COVERED, "covered"},
    {v1::CONTACT_FLAG_TOUCHING, "touching"}};

constexpr std::pair<client::ClosestFeatures, std::string_view> kNearerWords[] = {
    {client::kNearerAtFirst, "nearer_at_first"},
    {client::kNearerAtSecond, "nearer_at_second"},
    {client::kSameAsBefore, "same_as_before"}};

// The last place is none.
constexpr std::string_view kOnTriangleWords[] = {"face",     "side_1",   "side_2",   "side_3",
                                                 "corner_1", "corner_2", "corner_3", "unknown"};
constexpr std::string_view kOnEdgeWords[] = {"inside", "end_1", "end_2", "unknown"};

}  // namespace

Json contact_json(const std::string& kind, const client::Contacts& contacts, size_t i) {
  Json out = {{"kind", kind}};
  if (!contacts.elements.empty()) out["elements"] = contacts.elements[i];
  if (!contacts.stencils.empty()) out["stencil"] = contacts.stencils[i];
  if (!contacts.toi.empty()) out["toi"] = contacts.toi[i];
  if (!contacts.distance.empty()) out["distance"] = contacts.distance[i];
  if (!contacts.flags.empty()) out["flags"] = flag_words(contacts.flags[i]);
  return out;
}

std::vector<std::string_view> flag_words(uint8_t flags) {
  std::vector<std::string_view> words;
  for (const auto& [mask, word] : kFlagWords)
    if ((flags & mask) != 0) words.push_back(word);
  return words;
}

std::vector<std::string_view> feature_words(v1::ContactKind kind, uint8_t features) {
  std::vector<std::string_view> words;
  if (kind == v1::CONTACT_KIND_VERTEX_TRIANGLE)
    words = {"vertex", kOnTriangleWords[features & client::kOnTriangle]};
  else if (kind == v1::CONTACT_KIND_EDGE_EDGE)
    words = {kOnEdgeWords[features & client::kOnFirstEdge],
             kOnEdgeWords[(features & client::kOnSecondEdge) / (client::kOnFirstEdge + 1)]};
  else
    return {};
  for (const auto& [mask, word] : kNearerWords)
    if ((features & mask) != 0) words.push_back(word);
  return words;
}

std::optional<uint64_t> count_covered(const client::FrameOutput& output) {
  const auto is_covered = [](uint8_t flags) { return (flags & v1::CONTACT_FLAG_COVERED) != 0; };
  std::optional<uint64_t> covered;
  for_each_kind(
      [&](v1::ContactKind, const client::Contacts& contacts) {
        if (contacts.features.empty()) return;
        covered = covered.value_or(0) + static_cast<uint64_t>(std::ranges::count_if(contacts.flags, is_covered));
      },
      output);
  return covered;
}

void leave_out_covered(client::FrameOutput& output) {
  for_each_kind([](v1::ContactKind, client::Contacts& contacts) { contacts = client::kept(contacts); }, output);
}

std::optional<Json> earliest_contact(const client::FrameOutput& output) {
  std::optional<Json> earliest;
  double earliest_toi = std::numeric_limits<double>::infinity();
  for_each_kind(
      [&](v1::ContactKind kind, const client::Contacts& contacts) {
        const auto at = std::min_element(contacts.toi.begin(), contacts.toi.end());
        if (at == contacts.toi.end() || *at >= earliest_toi) return;
        earliest_toi = *at;
        earliest = contact_json(long_name_of(kind), contacts, static_cast<size_t>(at - contacts.toi.begin()));
      },
      output);
  return earliest;
}

}  // namespace collided::cli
