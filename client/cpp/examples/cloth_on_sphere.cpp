// An XPBD cloth that falls on a sphere, which turns, and folds onto itself; the daemon decides how far each step may
// go. As client/python/examples/cloth_on_sphere, but with every constraint projected in its turn.
//
// usage: cloth_on_sphere [FRAMES [CELLS]], with the daemon's address in COLLIDED_SERVER

#include <algorithm>
#include <cmath>
#include <collided/client.hpp>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "client/cpp/examples/scene.hpp"
#include "client/cpp/examples/shapes.hpp"

using namespace collided::client;
namespace v1 = collided::v1;

namespace {

constexpr double kStep = 1.0 / 120, kTurn = 2, kGravity = -9.8;  // s, of which two are a frame; rad/s; m/s^2
constexpr double kAir = 0.5;                                     // part of the velocity that is lost in a second
constexpr double kSide = 1.8, kDensity = 0.2, kDrop = 0.12;      // of the cloth: m, kg/m^2, m above the sphere
constexpr double kRadius = 0.3, kHeight = 0.4;                   // of the sphere, m
// How near features are looked for, what they are kept apart, how much of that is made up for in a step; m.
constexpr double kReach = 0.014, kGap = 0.008, kRecovery = 0.0005;
constexpr double kMinSeparation = 0.001, kFriction = 0.4;
constexpr double kFold = 0.3;  // m along the cloth, between points that meet where it folds onto itself

/// Of the cloth: neighbours along rows and columns, diagonals, and second neighbours against bending, each with its
/// compliance, m/N.
struct Direction {
  uint32_t down, right;
  double compliance;
};
constexpr Direction kDirections[] = {{0, 1, 0}, {1, 0, 0}, {1, 1, 0.1}, {1, ~0u, 0.1}, {0, 2, 3}, {2, 0, 3}};
constexpr int kSweeps = 8, kSettle = 100;

/// Two vertices that stay so far apart, or yield.
struct Spring {
  uint32_t a, b;
  double length, compliance, lambda = 0;
};

/// Two features that are close: what each vertex counts in the vector between the points that were the closest.
struct Pair {
  std::array<uint32_t, 4> vertices;
  std::array<double, 4> shares;
  Vec normal, start;
  double wanted, mobility;

  Vec apart(const std::vector<Vec>& p) const {
    Vec sum;
    for (int k = 0; k < 4; ++k) sum = sum + shares[k] * p[vertices[k]];
    return sum;
  }
};

class Simulation {
 public:
  Simulation(Client& client, uint32_t cells)
      : meshes_{make_floor(), make_sphere(kRadius, kHeight, 32, 16),
                make_sheet(kSide, kHeight + kRadius + kDrop, cells)},
        way_(client, way(), meshes_),
        judge_(client, judge(), meshes_) {
    for (const Mesh& mesh : meshes_) x_.insert(x_.end(), mesh.vertices.begin(), mesh.vertices.end());
    velocity_.resize(meshes_[2].vertices.size());
    cloth_ = static_cast<uint32_t>(x_.size() - velocity_.size());
    mass_ = kDensity * kSide * kSide / static_cast<double>(velocity_.size());
    add_springs(cells + 1);
    way_.ask(packed(x_), {.mode = v1::DETECTION_MODE_DCD});
  }

  struct Step {
    double advanced;
    size_t contacts, folds;
  };
  /// What is near, where the cloth wants to go, how far that is free.
  Step step() {
    const std::vector<Pair> near = pairs(way_.ask({}, {.mode = v1::DETECTION_MODE_DCD}));
    const std::vector<float> target = packed(wanted(near));
    const FrameOutput gone = way_.ask(target, {.advance = true, .advance_mode = v1::ADVANCE_MODE_PER_VERTEX});
    const std::vector<Vec> before = x_;
    go(target, gone.advance);
    // What was not gone is lost.
    for (size_t i = 0; i < velocity_.size(); ++i)
      velocity_[i] = (1 / kStep - kAir) * (x_[cloth_ + i] - before[cloth_ + i]);
    return {gone.done.advanced(), near.size(), count_folds(near)};
  }

  /// Edges that go through triangles, and features that touch, decided in real arithmetic. The cloth is free of
  /// self-intersection, and apart from the others, if and only if there are none.
  uint64_t count_crossings() { return judge_.ask(packed(x_), {}).done.contact_count(); }

 private:
  static v1::SceneSpec way() {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_DCD_AND_CCD);
    spec.set_thickness(kReach);
    spec.set_min_separation(kMinSeparation);
    for (const v1::ContactField field :
         {v1::CONTACT_FIELD_STENCIL, v1::CONTACT_FIELD_DISTANCE, v1::CONTACT_FIELD_WEIGHTS, v1::CONTACT_FIELD_NORMAL})
      spec.add_fields(field);
    return spec;
  }
  static v1::SceneSpec judge() {
    v1::SceneSpec spec;
    spec.set_mode(v1::DETECTION_MODE_DCD);
    spec.set_accuracy(v1::ACCURACY_EXACT);
    for (const v1::ContactKind kind :
         {v1::CONTACT_KIND_VERTEX_TRIANGLE, v1::CONTACT_KIND_EDGE_EDGE, v1::CONTACT_KIND_EDGE_TRIANGLE})
      spec.add_kinds(kind);
    return spec;
  }

  /// Moves all vertices to where the daemon has them, every bit.
  void go(const std::vector<float>& target, const FrameAdvance& advance) {
    std::vector<float> here = packed(x_);
    uint32_t first = 0;
    for (uint32_t mesh = 0; mesh < meshes_.size(); ++mesh) {
      const uint32_t count = static_cast<uint32_t>(meshes_[mesh].vertices.size());
      move_along(std::span(here).subspan(3 * first, 3 * count), std::span(target).subspan(3 * first, 3 * count),
                 advance, mesh, first);
      first += count;
    }
    for (size_t i = 0; i < x_.size(); ++i) x_[i] = {here[3 * i], here[3 * i + 1], here[3 * i + 2]};
    // A vertex of the sphere that is held back returns to its place in later steps.
    double farthest = 0;
    for (uint32_t v = static_cast<uint32_t>(meshes_[0].vertices.size()); v < cloth_; ++v)
      farthest = std::max(farthest, advance.of_vertex(1, v));
    turned_ += farthest * kTurn * kStep;
  }

  void add_springs(uint32_t row) {
    for (uint32_t i = 0; i < row; ++i)
      for (uint32_t j = 0; j < row; ++j)
        for (const auto& [down, right, compliance] : kDirections) {
          if (i + down >= row || j + right >= row) continue;  // right of -1 wraps round from column 0
          const uint32_t a = cloth_ + i * row + j, b = a + down * row + right;
          springs_.push_back({a, b, length(x_[a] - x_[b]), compliance});
        }
  }

  std::vector<Pair> pairs(const FrameOutput& near) const {
    std::vector<Pair> out;
    const auto add = [&](const Contacts& c, size_t i, const std::array<double, 4>& shares) {
      const auto& n = c.normals[i];
      Pair pair{c.stencils[i], shares, {n[0], n[1], n[2]}, {}, std::min(kGap, c.distance[i] + kRecovery), 0};
      pair.start = pair.apart(x_);
      for (int k = 0; k < 4; ++k) pair.mobility += pair.vertices[k] >= cloth_ ? shares[k] * shares[k] : 0;
      out.push_back(pair);
    };
    for (size_t i = 0; i < near.vertex_triangle.count; ++i) {
      const auto& w = near.vertex_triangle.weights[i];
      add(near.vertex_triangle, i, {1, w[0] + w[1] - 1, -w[0], -w[1]});
    }
    for (size_t i = 0; i < near.edge_edge.count; ++i) {
      const auto& w = near.edge_edge.weights[i];
      add(near.edge_edge, i, {1 - w[0], w[0], w[1] - 1, -w[1]});
    }
    return out;
  }

  /// Where all vertices would be after the step, if nothing were in the way.
  std::vector<Vec> wanted(const std::vector<Pair>& near) {
    std::vector<Vec> p = x_;
    const std::vector<Vec>& sphere = meshes_[1].vertices;
    const double angle = turned_ + kTurn * kStep, c = std::cos(angle), s = std::sin(angle);
    for (size_t i = 0; i < sphere.size(); ++i)
      p[cloth_ - sphere.size() + i] = {c * sphere[i].x - s * sphere[i].y, s * sphere[i].x + c * sphere[i].y,
                                       sphere[i].z};
    for (size_t i = 0; i < velocity_.size(); ++i)
      p[cloth_ + i] = p[cloth_ + i] + kStep * (velocity_[i] + Vec{0, 0, kStep * kGravity});
    for (Spring& spring : springs_) spring.lambda = 0;
    for (int i = 0; i < kSweeps; ++i) {
      for (Spring& spring : springs_) hold(spring, p);
      push_apart(near, p);
    }
    // Contacts come first: until no pair comes closer than it was.
    for (int i = 0; i < kSettle && push_apart(near, p) > kRecovery / 2; ++i) {
    }
    return p;
  }

  void hold(Spring& spring, std::vector<Vec>& p) const {
    const Vec apart = p[spring.a] - p[spring.b];
    const double now = length(apart), yielding = spring.compliance / (kStep * kStep);
    const double change = (spring.length - now - yielding * spring.lambda) / (2 / mass_ + yielding);
    spring.lambda += change;
    const Vec moved = change / (mass_ * std::max(now, 1e-12)) * apart;
    p[spring.a] = p[spring.a] + moved;
    p[spring.b] = p[spring.b] - moved;
  }

  /// Returns what was most missing.
  double push_apart(const std::vector<Pair>& near, std::vector<Vec>& p) const {
    double worst = 0;
    for (const Pair& pair : near) {
      const Vec apart = pair.apart(p);
      const double depth = pair.wanted - dot(apart, pair.normal);
      if (depth <= 0 || pair.mobility == 0) continue;
      worst = std::max(worst, depth);
      Vec slid = apart - pair.start;
      slid = slid - dot(slid, pair.normal) * pair.normal;
      const double held = std::min(1.0, kFriction * depth / std::max(length(slid), 1e-12));
      const Vec change = 1 / pair.mobility * (depth * pair.normal - held * slid);
      for (int k = 0; k < 4; ++k)
        if (pair.vertices[k] >= cloth_) p[pair.vertices[k]] = p[pair.vertices[k]] + pair.shares[k] * change;
    }
    return worst;
  }

  size_t count_folds(const std::vector<Pair>& near) const {
    const std::vector<Vec>& rest = meshes_[2].vertices;
    return static_cast<size_t>(std::count_if(near.begin(), near.end(), [&](const Pair& pair) {
      const auto [first, last] = std::minmax(pair.vertices[0], pair.vertices[3]);
      return first >= cloth_ && length(rest[first - cloth_] - rest[last - cloth_]) > kFold;
    }));
  }

  const std::array<Mesh, 3> meshes_;
  Scene way_, judge_;
  std::vector<Vec> x_, velocity_;  ///< of all vertices; of the cloth's
  std::vector<Spring> springs_;
  uint32_t cloth_ = 0;  ///< its first vertex; constraints move no other
  double mass_ = 0, turned_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 300, cells = argc > 2 ? std::atoi(argv[2]) : 40;
  Client client = Client::connect(std::getenv("COLLIDED_SERVER"));
  Simulation simulation(client, static_cast<uint32_t>(cells));
  uint64_t crossings = 0;
  std::vector<double> advanced;
  for (int frame = 1; frame <= frames; ++frame) {
    advanced.push_back(simulation.step().advanced);
    const Simulation::Step last = simulation.step();
    advanced.push_back(last.advanced);
    crossings += simulation.count_crossings();
    if (frame % 30 != 0 && frame != frames) continue;
    std::sort(advanced.begin(), advanced.end());
    std::printf("frame %d: %llu pairs met so far, %zu contacts, %zu of folds, advanced %.3f (least %.3f)\n", frame,
                static_cast<unsigned long long>(crossings), last.contacts, last.folds, advanced[advanced.size() / 2],
                advanced.front());
  }
  return crossings == 0 ? 0 : 1;
}
