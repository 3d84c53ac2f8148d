#include <algorithm>
#include <cstring>
#include <map>

#include "tests/integration/model/session.hpp"

namespace collided::test {
namespace {

template <class T>
std::vector<T> unpack(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

struct Told {
  double toi = 0;
  uint8_t flags = 0;
};
using ToldContacts = std::map<PairKey, Told>;

void take(const pb::ContactChunk& chunk, bool discrete, ToldContacts& told) {
  const auto ids = unpack<uint32_t>(chunk.elements());
  const auto times = unpack<double>(chunk.toi());
  require(ids.size() == 2 * chunk.count() && chunk.flags().size() == chunk.count(), "arrays of other lengths");
  require(discrete || times.size() == chunk.count(), "no time for each contact");
  for (size_t i = 0; i < chunk.count(); ++i) {
    const PairKey key = key_of(ids[2 * i], ids[2 * i + 1]);
    require(told.empty() || told.rbegin()->first < key, "contacts out of order");
    told[key] = {discrete ? 1 : times[i], static_cast<uint8_t>(chunk.flags()[i])};
  }
}

std::string text_of(PairKey key) { return std::to_string(key >> 32) + "-" + std::to_string(key & 0xffffffff); }

void compare(const std::string& kind, const ToldContacts& told, const ContactTimes& truth, bool exact) {
  for (const auto& [key, latest] : truth) {
    require(told.contains(key), kind + " " + text_of(key) + " is missing");
    require(told.at(key).toi <= latest, kind + " " + text_of(key) + " is told too late: at " +
                                            std::to_string(told.at(key).toi) + " instead of " + std::to_string(latest) +
                                            ", by " + std::to_string((told.at(key).toi - latest) * 0x1p52) + " / 2^52");
  }
  for (const auto& [key, contact] : told) {
    const bool certain = exact || (contact.flags & pb::CONTACT_FLAG_CERTIFIED) != 0;
    require(!certain || truth.contains(key), kind + " " + text_of(key) + " is none");
  }
}

/// The contacts, `earliest_toi` and `advanced` of a frame that advances tell one story. `starts_apart`: the model's.
void check_story(const ToldContacts& vertex_triangle, const ToldContacts& edge_edge, bool exact, bool starts_apart,
                 double thickness, const pb::FrameDone& done) {
  bool is_free = true;
  double earliest = 1;
  for (const auto* contacts : {&vertex_triangle, &edge_edge})
    for (const auto& [key, contact] : *contacts) {
      if ((contact.flags & pb::CONTACT_FLAG_SEPARATING) != 0) continue;
      is_free = false;
      earliest = std::min(earliest, contact.toi);
    }
  require(done.earliest_toi() == earliest, "earliest_toi is not that of the earliest contact that approaches");
  // Features that start too near may go on if they come no nearer. Features that touch stand still.
  if (!starts_apart) return;
  if (is_free) return require(done.advanced() == 1, "nothing approaches, but the scene did not go all of the way");
  if (thickness > 0) return;  // on the way features come a little nearer than the separation
  // Certificates hold at the end of a way, where the margin of CERTIFIED may just be reached.
  const bool is_end = !exact && earliest == 1;
  require(done.advanced() == 0 || done.advanced() < earliest || is_end, "the scene went on to a contact");
}

}  // namespace

void check_answer(const SceneModel& model, const ModelFrame& frame, pb::Accuracy accuracy, const Way& way,
                  const std::vector<pb::ContactChunk>& chunks, const pb::FrameDone& done) {
  ToldContacts vertex_triangle, edge_edge;
  for (const auto& chunk : chunks)
    take(chunk, frame.discrete, chunk.kind() == pb::CONTACT_KIND_VERTEX_TRIANGLE ? vertex_triangle : edge_edge);
  const ModelContacts truth = model.contacts(way, frame.discrete);
  const bool exact = accuracy == pb::ACCURACY_EXACT;
  compare("vertex-triangle", vertex_triangle, truth.vertex_triangle, exact);
  compare("edge-edge", edge_edge, truth.edge_edge, exact);

  const size_t count = vertex_triangle.size() + edge_edge.size();
  require(done.contact_count() == count, "contact_count is not the number of contacts");
  if (!frame.advance) {
    double earliest = 1;
    for (const auto* contacts : {&vertex_triangle, &edge_edge})
      for (const auto& [key, contact] : *contacts) earliest = std::min(earliest, contact.toi);
    require(done.any_contact() == (count > 0), "any_contact is wrong");
    require(done.earliest_toi() == earliest, "earliest_toi is not the earliest contact's");
  }
  require(done.has_advanced() == frame.advance, "advanced is not where it should be");
  if (!frame.advance) return;
  require(done.advanced() >= 0 && done.advanced() <= 1, "advanced is out of range");
  const bool starts_apart = model.starts_apart(way);
  check_story(vertex_triangle, edge_edge, exact, starts_apart, model.thickness(), done);
  const Way gone{way.from, point_of(way, done.advanced())};
  require(!model.meets(gone, 0), "an advance led into touch");
  require(!starts_apart || !model.meets(gone, 7.0 / 8 * model.thickness()), "an advance led into contact");
}

}  // namespace collided::test
