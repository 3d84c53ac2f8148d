#include "tests/support/families/query_families.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "tests/support/families/query_families_shapes.hpp"

namespace collided::test {
namespace {

// Volatile: see through_float in case.cpp.
double through_float(double x) {
  volatile float narrow = static_cast<float>(x);
  return static_cast<double>(narrow);
}

// Sources differ in all but a few queries even where their seeds are alike.
uint64_t seed_of(const QuerySource& source, uint64_t index) {
  uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](uint64_t value) { hash = (hash ^ value) * 0x100000001b3u; };
  for (char c : source.family->name) add(static_cast<unsigned char>(c));
  add(static_cast<uint64_t>(source.kind));
  add(static_cast<uint64_t>(source.scalar));
  Random mixed(hash ^ source.seed);
  return mixed.next() + Random(index).next();
}

}  // namespace

const QueryFamily& fuzz_family(const std::string& name) {
  for (const QueryFamily& family : fuzz_families())
    if (family.name == name) return family;
  throw std::invalid_argument("no fuzz family is named \"" + name + '"');
}

Query query_of(const QuerySource& source, uint64_t index) {
  Random random(seed_of(source, index));
  return rounded(source.family->make(source.kind, source.scalar, random), source.scalar);
}

std::vector<Query> queries_of(const QuerySource& source, uint64_t count) {
  std::vector<Query> queries;
  queries.reserve(count);
  for (uint64_t i = 0; i < count; ++i) queries.push_back(query_of(source, i));
  return queries;
}

Query rounded(Query query, Scalar scalar) {
  if (scalar == Scalar::kF32)
    for (Vec3d& p : query.p)
      for (double& x : p) x = through_float(x);
  return query;
}

double extent_of(const Query& query) {
  double extent = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    double low = query.p[0][axis], high = low;
    for (const Vec3d& p : query.p) {
      low = std::min(low, p[axis]);
      high = std::max(high, p[axis]);
    }
    extent = std::max(extent, high - low);
  }
  return extent;
}

std::string text_of(const Query& query) {
  std::string text = name_of(query.kind);
  char number[40];
  for (const Vec3d& p : query.p) {
    for (double x : p) {
      std::snprintf(number, sizeof number, " %a", x);
      text += number;
    }
  }
  return text;
}

Query query_from(const std::string& text) {
  std::istringstream in(text);
  std::string word;
  in >> word;
  if (word != "VT" && word != "EE") throw std::invalid_argument("a query begins with VT or EE, not \"" + word + '"');
  Query query{word == "VT" ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge, {}};
  for (Vec3d& p : query.p) {
    for (double& x : p) {
      if (!(in >> word)) throw std::invalid_argument("a query has 24 coordinates");
      x = std::strtod(word.c_str(), nullptr);  // std::stod throws for denormals
    }
  }
  return query;
}

std::string name_of(QueryKind kind) { return kind == QueryKind::kVertexTriangle ? "VT" : "EE"; }
std::string name_of(Scalar scalar) { return scalar == Scalar::kF32 ? "F32" : "F64"; }

}  // namespace collided::test
