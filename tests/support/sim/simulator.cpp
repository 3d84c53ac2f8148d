#include "tests/support/sim/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace collided::test {
namespace {

constexpr int kIterations = 12;

Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3d operator-(const Vec3d& a, const Vec3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3d operator*(double s, const Vec3d& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3d& a) { return std::sqrt(dot(a, a)); }

/// The formula of client/STEPPING.md.
double moved_along(double x, double p, double a, Scalar scalar) {
  if (a == 0 || a == 1) return a == 0 ? x : p;
  const double to = x + a * (p - x);
  return scalar == Scalar::kF64 ? to : static_cast<double>(static_cast<float>(to));
}

uint32_t first_vertex(const Case& c, uint32_t mesh) {
  uint32_t first = 0;
  for (uint32_t m = 0; m < mesh; ++m) first += c.meshes[m].vertex_count;
  return first;
}

Positions joined(const std::vector<Positions>& meshes) {
  Positions all;
  for (const Positions& mesh : meshes) all.insert(all.end(), mesh.begin(), mesh.end());
  return all;
}

/// Vertices of a contact, with the share that each has in the vector between the closest points.
struct Share {
  uint32_t vertex;
  double weight;
};
std::array<Share, 4> shares_of(const Topology& topology, ContactKind kind, const std::array<uint32_t, 2>& elements,
                               const std::array<double, 2>& w) {
  if (kind == ContactKind::kVertexTriangle) {
    const auto& t = topology.triangles[elements[1]];
    return {{{elements[0], 1}, {t[0], -(1 - w[0] - w[1])}, {t[1], -w[0]}, {t[2], -w[1]}}};
  }
  const auto &e = topology.edges[elements[0]], &f = topology.edges[elements[1]];
  return {{{e[0], 1 - w[0]}, {e[1], w[0]}, {f[0], -(1 - w[1])}, {f[1], -w[1]}}};
}

}  // namespace

void add_springs(Bodies& bodies, uint32_t mesh) {
  const uint32_t first = first_vertex(bodies.meshes, mesh);
  const Positions& x = bodies.meshes.start[mesh];
  const auto add = [&](uint32_t a, uint32_t b) {
    bodies.springs.push_back({first + a, first + b, length(x[a] - x[b])});
  };
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> opposite;  // of each edge met once
  for (const auto& t : bodies.meshes.meshes[mesh].triangles)
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const auto [known, is_new] = opposite.try_emplace(std::minmax(a, b), c);
      is_new ? add(a, b) : add(known->second, c);
    }
}

void make_stiff(Bodies& bodies, uint32_t mesh) {
  const uint32_t first = first_vertex(bodies.meshes, mesh);
  const Positions& x = bodies.meshes.start[mesh];
  for (uint32_t a = 0; a < x.size(); ++a)
    for (uint32_t b = a + 1; b < x.size(); ++b) bodies.springs.push_back({first + a, first + b, length(x[a] - x[b])});
}

Simulator::Simulator(Bodies bodies, Backend backend, Scalar scalar, AdvanceMode mode)
    : bodies_(std::move(bodies)), scalar_(scalar), mode_(mode) {
  bodies_.meshes.end = bodies_.meshes.start;
  bodies_.meshes = rounded(bodies_.meshes, scalar);
  x_ = before_ = joined(bodies_.meshes.start);
  v_ = bodies_.velocity.empty() ? Positions(x_.size()) : bodies_.velocity;
  bodies_.pull.resize(x_.size());
  for (const MeshSpec& mesh : bodies_.meshes.meshes)
    is_static_.insert(is_static_.end(), mesh.vertex_count, mesh.motion == MeshMotion::kStatic);
  SceneSpec spec;
  spec.device.backend = backend;
  spec.scalar = scalar;
  spec.mode = Mode::kDcd;
  spec.thickness = bodies_.repulsion;
  spec.fields = {ContactField::kElements, ContactField::kDistance, ContactField::kWeights, ContactField::kNormals};
  near_ = Detector::create(spec_for(bodies_.meshes, spec));
  spec.mode = Mode::kCcd;
  spec.thickness = spec.min_separation = bodies_.min_separation;
  spec.fields = {ContactField::kElements, ContactField::kToi};
  advance_ = Detector::create(spec_for(bodies_.meshes, spec));
  near_->detect(Frame(bodies_.meshes, Mode::kDcd, scalar).input());
  advance_->detect(Frame(bodies_.meshes, Mode::kDcd, scalar).input());
}
Simulator::~Simulator() = default;

Case Simulator::case_of(const Positions& start, const Positions& end) const {
  Case c = bodies_.meshes;
  size_t first = 0;
  for (size_t m = 0; m < c.meshes.size(); ++m) {
    const auto from = static_cast<std::ptrdiff_t>(first), to = static_cast<std::ptrdiff_t>(first + c.start[m].size());
    c.start[m].assign(start.begin() + from, start.begin() + to);
    c.end[m].assign(end.begin() + from, end.begin() + to);
    first += c.start[m].size();
  }
  return rounded(c, scalar_);
}
Case Simulator::last_way() const { return case_of(before_, x_); }

Positions Simulator::wanted() const {
  const double dt = bodies_.time_step;
  Positions p = x_;
  for (uint32_t i = 0; i < p.size(); ++i) {
    if (is_static_[i]) continue;
    p[i] =
        bodies_.pull[i] != 0 ? x_[i] + Vec3d{bodies_.pull[i] * dt, 0, 0} : x_[i] + dt * (v_[i] + dt * bodies_.gravity);
  }
  return p;
}

void Simulator::hold_together(Positions& p) const {
  for (const Spring& s : bodies_.springs) {
    const double mobile = (is_free(s.a) ? 1 : 0) + (is_free(s.b) ? 1 : 0);
    const Vec3d d = p[s.a] - p[s.b];
    const double now = length(d);
    if (mobile == 0 || !(now > 0)) continue;
    const Vec3d change = ((now - s.length) / (now * mobile)) * d;
    if (is_free(s.a)) p[s.a] = p[s.a] - change;
    if (is_free(s.b)) p[s.b] = p[s.b] + change;
  }
}

void Simulator::push_apart(Positions& p, const FrameResult& near) const {
  const Topology& topology = near_->topology();
  for_each_kind(
      [&](ContactKind kind, const ContactSet& set) {
        for (size_t i = 0; i < set.size(); ++i) {
          const auto shares = shares_of(topology, kind, set.elements[i], set.weights[i]);
          const Vec3d n{set.normals[i][0], set.normals[i][1], set.normals[i][2]};
          double distance = 0, mobile = 0;
          for (const auto& [vertex, w] : shares) {
            distance += w * dot(n, p[vertex]);
            if (is_free(vertex)) mobile += w * w;
          }
          if (distance >= bodies_.repulsion || mobile == 0) continue;
          for (const auto& [vertex, w] : shares)
            if (is_free(vertex)) p[vertex] = p[vertex] + ((bodies_.repulsion - distance) / mobile * w) * n;
        }
      },
      near);
}

std::vector<double> Simulator::fractions(const FrameResult& way) const {
  std::vector<double> all(x_.size(), mode_ == AdvanceMode::kAllOrOne ? way.advanced.value() : 1);
  for (size_t i = 0; i < way.shortened.ids.size(); ++i) {
    const uint32_t id = way.shortened.ids[i];
    if (mode_ == AdvanceMode::kPerVertex)
      all[id] = way.shortened.fractions[i];
    else
      std::fill_n(all.begin() + first_vertex(bodies_.meshes, id), bodies_.meshes.meshes[id].vertex_count,
                  way.shortened.fractions[i]);
  }
  return all;
}

Simulator::Step Simulator::step() {
  const Case here = case_of(x_, x_);
  const FrameResult near = near_->detect(Frame(here, Mode::kDcd, scalar_, false).input());
  Positions p = wanted();
  for (int i = 0; i < kIterations; ++i) {
    hold_together(p);
    push_apart(p, near);
  }
  const Case there = case_of(p, p);
  const Frame frame(there, Mode::kDcd, scalar_, false);
  FrameInput input = frame.input();
  input.advance = true;
  input.advance_mode = mode_;
  const FrameResult way = advance_->detect(input);
  const Step step{way.advanced.value(), way.way, way.earliest_toi, way.vertex_triangle.size() + way.edge_edge.size()};

  const Positions target = joined(there.end);
  const std::vector<double> fraction = fractions(way);
  before_ = x_;
  for (uint32_t i = 0; i < x_.size(); ++i) {
    for (int k = 0; k < 3; ++k) x_[i][k] = moved_along(x_[i][k], target[i][k], fraction[i], scalar_);
    v_[i] = 0.99 * (1 / bodies_.time_step * (x_[i] - before_[i]));
  }
  return step;
}

}  // namespace collided::test
