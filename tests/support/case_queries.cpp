#include "tests/support/case_queries.hpp"

namespace collided::test {
namespace {

Positions joined(const std::vector<Positions>& parts) {
  Positions all;
  for (const Positions& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

CaseQueries::CaseQueries(const Case& c) : features_(features_of(c)), start_(joined(c.start)), end_(joined(c.end)) {}

Query CaseQueries::of_vertices(QueryKind kind, const std::array<uint32_t, 4>& vertices) const {
  Query query{kind, {}};
  for (size_t k = 0; k < 4; ++k) {
    query.p[k] = start_.at(vertices[k]);
    query.p[k + 4] = end_.at(vertices[k]);
  }
  return query;
}

Query CaseQueries::of_pair(QueryKind kind, PairKey pair) const { return of_vertices(kind, vertices_of(kind, pair)); }

std::array<uint32_t, 4> CaseQueries::vertices_of(QueryKind kind, PairKey pair) const {
  const auto first = static_cast<uint32_t>(pair >> 32), second = static_cast<uint32_t>(pair);
  if (kind == QueryKind::kVertexTriangle) {
    const auto& corners = features_.triangles.at(second);
    return {first, corners[0], corners[1], corners[2]};
  }
  const auto &e = features_.edges.at(first), &f = features_.edges.at(second);
  return {e[0], e[1], f[0], f[1]};
}

}  // namespace collided::test
