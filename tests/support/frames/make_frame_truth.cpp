// Regenerates the truth of our own frames, byte for byte:   make_frame_truth tests/support/data/cloth_drape/truth
//
// The judge decides every pair whose boxes over the step overlap; brute force finds these. Pairs that collide are
// listed, and pairs that come close.

#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/case_queries.hpp"
#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

constexpr double kClose = 1e-3;  // m, a thirtieth of the edges: a miss that comes closer is listed

// Rounded to 16 digits after the point, of which the last is right to within one.
std::string decimal(const ExactImpact& impact) {
  constexpr size_t kDigits = 16;
  mpz_class unit;
  mpz_ui_pow_ui(unit.get_mpz_t(), 10, kDigits);
  const mpq_class twice = (impact.lower + impact.upper) * mpq_class(unit) + 1;  // rounds (lower + upper) / 2
  mpz_class value;
  mpz_fdiv_q(value.get_mpz_t(), twice.get_num_mpz_t(), mpz_class(2 * twice.get_den()).get_mpz_t());
  std::string digits = value.get_str();
  if (digits.size() <= kDigits) digits.insert(0, kDigits + 1 - digits.size(), '0');
  return digits.insert(digits.size() - kDigits, ".");
}

void write_ids(std::ostream& out, QueryKind kind, PairKey pair, const std::array<uint32_t, 4>& vertices) {
  if (kind == QueryKind::kVertexTriangle) {
    out << (pair >> 32) << ',' << static_cast<uint32_t>(pair);
    return;
  }
  out << vertices[0] << ',' << vertices[1] << ',' << vertices[2] << ',' << vertices[3];
}

void write_kind(std::ostream& out, const CaseQueries& queries, QueryKind kind, const std::vector<PairKey>& pairs) {
  size_t hits = 0, close = 0;
  for (const PairKey pair : pairs) {
    const Query query = queries.of_pair(kind, pair);
    const ExactImpact impact = judge_ccd(query);
    if (!impact.hit && !judge_ccd(query, kClose).hit) continue;
    ++(impact.hit ? hits : close);
    write_ids(out, kind, pair, queries.vertices_of(kind, pair));
    out << (impact.hit ? ",1," + decimal(impact) : ",0,") << '\n';
  }
  std::cerr << pairs.size() << " candidates: " << hits << " collide, " << close << " come close\n";
}

void write_truth(const std::filesystem::path& folder) {
  const Case c = load(kDrapeFrames);
  const ExpectedPairs pairs = brute_force(c, Mode::kCcd, Scalar::kF64, 0);
  const CaseQueries queries(c);
  std::ofstream vf(folder / "vf.csv"), ee(folder / "ee.csv");
  vf << "vertex,triangle,collides,toi\n";
  write_kind(vf, queries, QueryKind::kVertexTriangle, pairs.vertex_triangle.must);
  ee << "a0,a1,b0,b1,collides,toi\n";
  write_kind(ee, queries, QueryKind::kEdgeEdge, pairs.edge_edge.must);
  if (!vf.flush() || !ee.flush()) throw std::runtime_error("cannot write to " + folder.string());
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_frame_truth FOLDER\n";
    return 2;
  }
  try {
    collided::test::write_truth(argv[1]);
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "make_frame_truth: " << e.what() << '\n';
    return 1;
  }
}
