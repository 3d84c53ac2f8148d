#pragma once
// Queries whose first time of contact is known because they were built around it, in rational arithmetic.
//
// All constructions are one idea: in some frame the features stay in parallel planes (or, all in one plane, on two
// sides of a line), and the distance of these is a multiple of (t - t*). So they can meet at t = t* only (or first),
// and they do if the planes' contents meet at t*, which is known from the weights they were made with.

#include <cstdint>
#include <string>

#include "tests/support/labelled/labelled.hpp"

namespace collided::test {

using ExactVec = std::array<mpq_class, 3>;

ExactVec operator+(const ExactVec& a, const ExactVec& b);
ExactVec operator-(const ExactVec& a, const ExactVec& b);
ExactVec operator*(const mpq_class& factor, const ExactVec& v);

/// Our own generator: the standard distributions differ between libraries.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(seed) {}
  uint64_t bits();
  int between(int low, int high);  ///< both included
  bool chance() { return bits() & 1; }
  mpq_class fraction(int low, int high, int bits);  ///< low..high in steps of 2^-bits
  ExactVec vector(int size);                        ///< integer coordinates in [-size, size]
  double real();                                    ///< [-1, 1), 53 random bits

 private:
  uint64_t state_;
};

/// Where the four points are at time `at`, their velocities, and what is known about the contact.
struct Made {
  QueryKind kind = QueryKind::kVertexTriangle;
  mpq_class at;
  std::array<ExactVec, 4> x{}, v{};
  bool hit = false;
  mpq_class first;  ///< time of a hit

  void move_all(const ExactVec& by);
  void add_velocity(const ExactVec& velocity);  ///< the same for all points: a common translation
  void scale(int exponent);                     ///< all coordinates times 2^exponent
  /// False where some coordinate at t = 0 or 1 is not exactly a double.
  bool to_query(Query& query) const;
};

/// Three integer vectors that are linearly independent: the first two span the planes, the third leads through them.
struct Frame3 {
  ExactVec u, w, q;
};
Frame3 frame(Dice& dice, int size);

/// The vertex at a + x (b - a) + y (c - a) of the triangle when it goes through its plane at time t. Corners may
/// move within the plane.
struct Crossing {
  mpq_class t, x, y;
};
Made vertex_through_triangle(Dice& dice, const Frame3& f, const Crossing& c, bool deforms);
/// The edges cross at the fractions x and y of their lengths.
Made edge_through_edge(Dice& dice, const Frame3& f, const Crossing& c, bool deforms);

/// Edges along one line at time t: the second from fraction x to y of the first.
Made parallel_edges(Dice& dice, const Frame3& f, const Crossing& c);

/// All points in one plane at all times: a vertex reaches the line of the side a b (or an end of an edge that of the
/// other) at its fraction x, from outside; x beyond [0, 1] is a miss.
Made vertex_within_plane(const Frame3& f, const Crossing& c);
Made edge_within_plane(const Frame3& f, const Crossing& c);

/// A triangle turns about an axis while the vertex goes by: the vertex's distance to the plane is a multiple of
/// (t - c.t)^2 - depth, and the foot is inside, so the cubic has two roots, one double root (depth 0), or none. `half`
/// is the root of |depth|, in [0, 1/2]. Or the same with an edge that turns and one that goes by.
Made touching_turning(QueryKind kind, const Frame3& f, const mpq_class& t, const mpq_class& half, bool reaches);

/// Whether weights are within a triangle, and within an edge.
bool in_triangle(const mpq_class& x, const mpq_class& y);
bool in_edge(const mpq_class& x);

}  // namespace collided::test
