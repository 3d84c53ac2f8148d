// The families through a whole scene: a pair lost by the boxes or the octree never reaches the narrow phase.

#include <algorithm>

#include "tests/support/verdicts/verdict_score_checks.hpp"

namespace collided::test {
namespace {

constexpr uint64_t kQueries = 12;

// Two meshes: triangle i of each holds the features of query i. The features' missing corners are repeated ones.
Case scene_of(const std::vector<Query>& queries) {
  std::array<Positions, 2> start, end;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (const Query& q : queries) {
    const bool vt = q.kind == QueryKind::kVertexTriangle;
    const std::array<std::array<size_t, 3>, 2> corners{
        vt ? std::array<size_t, 3>{0, 0, 0} : std::array<size_t, 3>{0, 1, 1},
        vt ? std::array<size_t, 3>{1, 2, 3} : std::array<size_t, 3>{2, 3, 3}};
    const auto first = static_cast<uint32_t>(start[0].size());
    triangles.push_back({first, first + 1, first + 2});
    for (size_t mesh = 0; mesh < 2; ++mesh) {
      for (size_t corner : corners[mesh]) {
        start[mesh].push_back(q.p[corner]);
        end[mesh].push_back(q.p[corner + 4]);
      }
    }
  }
  Case c;
  for (size_t mesh = 0; mesh < 2; ++mesh) {
    add_mesh(c, triangles, std::move(start[mesh]), std::move(end[mesh]));
    c.meshes[mesh].self_contacts = false;
  }
  return c;
}

uint32_t edge_id(const Topology& topology, uint32_t from, uint32_t to) {
  const auto& edges = topology.edges;
  const auto at = std::find(edges.begin(), edges.end(), std::array<uint32_t, 2>{from, to});
  return static_cast<uint32_t>(at - edges.begin());
}

// The scene-wide ids of query i's features.
std::array<uint32_t, 2> features_of_query(const Topology& topology, QueryKind kind, uint32_t i) {
  const auto vertex = 3 * i, other = topology.vertex_offset[1] + 3 * i;
  if (kind == QueryKind::kVertexTriangle) return {vertex, topology.triangle_offset[1] + i};
  return {edge_id(topology, vertex, vertex + 1), edge_id(topology, other, other + 1)};
}

std::vector<Verdict> verdicts_of_scene(const Judged& truth, Accuracy accuracy, Scalar scalar) {
  const Case c = scene_of(truth.queries);
  const std::unique_ptr<Detector> detector = Detector::create(spec_for(c, settings(truth.mode, accuracy, scalar)));
  const Frame frame(c, truth.mode, scalar);
  const FrameResult result = detector->detect(frame.input());
  const QueryKind kind = truth.queries[0].kind;
  const ContactSet& contacts = kind == QueryKind::kVertexTriangle ? result.vertex_triangle : result.edge_edge;
  std::vector<Verdict> verdicts;
  for (uint32_t i = 0; i < truth.queries.size(); ++i) {
    const auto ids = features_of_query(detector->topology(), kind, i);
    const auto at = static_cast<size_t>(std::find(contacts.elements.begin(), contacts.elements.end(), ids) -
                                        contacts.elements.begin());
    if (at == contacts.size())
      verdicts.push_back({});
    else
      verdicts.push_back({true, contacts.toi[at], contacts.distance[at], contacts.flags[at]});
  }
  return verdicts;
}

class WholeDetector : public OnBackend<::testing::TestWithParam<FamilyCase>> {};

TEST_P(WholeDetector, MissesNothingAndIsNotLate) {
  const auto [family, scalar] = GetParam();
  for (QueryKind kind : kQueryKinds) {
    const Judged truth = judged({{family, kind, scalar, 2}, kQueries});
    for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
      SCOPED_TRACE(name_of(kind) + " " + name_of(accuracy));
      std::vector<Offence> offences;
      const std::vector<Verdict> verdicts = verdicts_of_scene(truth, accuracy, scalar);
      score(truth, verdicts, accuracy, &offences);
      for (const Offence& o : offences)
        ADD_FAILURE() << "query " << o.query << ": " << o.what << "\n  verdict: " << text_of(verdicts[o.query])
                      << "\n  truth:   " << text_of(truth.truth[o.query]) << "\n  " << text_of(truth.queries[o.query]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Families, WholeDetector, ::testing::ValuesIn(cases_of(extreme_families())),
                         [](const auto& info) { return case_name(info.param); });

}  // namespace
}  // namespace collided::test
