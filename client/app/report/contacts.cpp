// One contact for people and as JSON.

#include "client/app/report/contacts.hpp"

#include <algorithm>
#include <limits>

namespace collided::cli {

namespace {

constexpr std::pair<v1::ContactFlag, std::string_view> kFlagWords[] = {
    {v1::CONTACT_FLAG_CERTIFIED, "certified"},   {v1::CONTACT_FLAG_NEAR, "near"},
    {v1::CONTACT_FLAG_CAPPED, "capped"},         {v1::CONTACT_FLAG_INITIAL, "initial"},
    {v1::CONTACT_FLAG_SEPARATING, "separating"}, {v1::CONTACT_FLAG_TOUCHING, "touching"}};

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
