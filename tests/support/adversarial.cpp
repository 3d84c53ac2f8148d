#include "tests/support/adversarial.hpp"

#include <cmath>
#include <random>
#include <utility>

namespace collided::test {
namespace {

// Our own generator: the standard distributions differ between libraries.
class Random {
 public:
  explicit Random(uint32_t seed) : state_(seed * 0x9e3779b97f4a7c15ull + 1) {}
  double operator()() {  // [-0.5, 0.5)
    state_ += 0x9e3779b97f4a7c15ull;
    uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53 - 0.5;
  }
  Vec3d point(double scale, const Vec3d& centre = {}) {
    Vec3d p;
    for (int k = 0; k < 3; ++k) p[k] = centre[k] + scale * (*this)();
    return p;
  }

 private:
  uint64_t state_;
};

std::vector<std::array<uint32_t, 3>> separate_triangles(size_t vertices) {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t v = 0; v + 2 < vertices; v += 3) triangles.push_back({v, v + 1, v + 2});
  return triangles;
}

Case one_mesh(const char* name, Positions start, Positions end = {}) {
  Case c;
  c.name = name;
  auto triangles = separate_triangles(start.size());
  add_mesh(c, std::move(triangles), std::move(start), std::move(end));
  return c;
}

Case named(Case c, const char* name) {
  c.name = name;
  return c;
}

// Boxes that share only faces, edges or corners with their neighbours: closed boxes must overlap.
Case touching_on_lattice() {
  Positions p;
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 6; ++y)
      for (int z = 0; z < 6; ++z) {
        const Vec3d low{x * 0.25, y * 0.25, z * 0.25};
        p.push_back(low);
        p.push_back({low[0] + 0.25, low[1] + 0.25, low[2]});
        p.push_back({low[0], low[1] + 0.25, low[2] + 0.25});
      }
  return one_mesh("TouchingOnLattice", std::move(p));
}

// Axis-parallel flat triangles: boxes without volume, all in a few planes.
Case flat_plane() {
  Positions p;
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y) {
      p.push_back({double(x), double(y), 0});
      p.push_back({double(x + 1), double(y), 0});
      p.push_back({double(x), double(y + 1), 0});
    }
  return one_mesh("FlatPlane", std::move(p));
}

Case one_huge_triangle() {
  Case c = soup(11, 500, 1, 0.02, 0.01);
  add_mesh(c, {{0, 1, 2}}, {{-100, -100, 0}, {100, -90, 1}, {0, 120, -1}});
  return named(std::move(c), "OneHugeTriangle");
}

void scale_axes(Case& c, const Vec3d& factor) {
  for (auto* all : {&c.start, &c.end})
    for (Positions& positions : *all)
      for (Vec3d& p : positions)
        for (int k = 0; k < 3; ++k) p[k] *= factor[k];
}

Case anisotropic() {
  Case c = soup(12, 600, 1, 0.05, 0.02);
  scale_axes(c, {1000, 1, 1e-4});
  return named(std::move(c), "AnisotropicThin");
}

// A dense tiny cluster, a middle one and a wide one in the same place.
Case mixed_scale() {
  Case c = soup(13, 300, 100, 20, 1);
  for (const Case& part : {soup(14, 300, 1, 0.1, 0.01), soup(15, 300, 1e-3, 2e-4, 1e-5)})
    add_mesh(c, part.meshes[0].triangles, part.start[0], part.end[0]);
  return named(std::move(c), "MixedScale");
}

// Different vertices in the same places, triangles that are points or segments, the same triangle twice.
Case duplicated_vertices() {
  Case c = soup(16, 150, 1, 0.2, 0.02);
  for (Positions* all : {&c.start[0], &c.end[0]}) {
    const Positions copy = *all;
    all->insert(all->end(), copy.begin(), copy.end());
    for (size_t v = 0; v < 60; v += 3) (*all)[v + 1] = (*all)[v];
    for (size_t v = 0; v < 30; v += 3) (*all)[v + 2] = (*all)[v];
  }
  c.meshes[0].vertex_count *= 2;
  c.meshes[0].triangles = separate_triangles(c.start[0].size());
  c.meshes[0].triangles.push_back(c.meshes[0].triangles.back());
  return named(std::move(c), "DuplicatedVertices");
}

// A closed fan: every triangle shares the middle vertex, most pairs share something.
Case fan() {
  Positions p{{0, 0, 0.5}};
  std::vector<std::array<uint32_t, 3>> triangles;
  constexpr uint32_t kBlades = 64;
  for (uint32_t i = 0; i < kBlades; ++i) {
    const double angle = 6.283185307179586 * i / kBlades;
    p.push_back({std::cos(angle), std::sin(angle), (i % 2) * 0.25});
    triangles.push_back({0, i + 1, (i + 1) % kBlades + 1});
  }
  Case c;
  c.name = "Fan";
  add_mesh(c, std::move(triangles), std::move(p));
  return c;
}

Case static_obstacles() {
  Case c = soup(17, 300, 1, 0.1, 0.05);
  for (uint32_t seed : {18u, 19u}) {
    const Case part = soup(seed, 200, 1, 0.15, 0);
    add_mesh(c, part.meshes[0].triangles, part.start[0], {}, true);
  }
  return named(std::move(c), "StaticObstacles");
}

// Each mesh's mask lets it touch its own group and the next; only mutual consent counts.
Case group_masks() {
  Case c;
  for (uint32_t m = 0; m < 4; ++m) {
    const Case part = soup(20 + m, 200, 1, 0.12, 0.03);
    add_mesh(c, part.meshes[0].triangles, part.start[0], part.end[0]);
    c.meshes[m].groups = 1u << m;
    c.meshes[m].collide_mask = 1u << m | 1u << ((m + 1) % 4) | (m % 2 ? 1u << (m - 1) : 0u);
    c.meshes[m].self_contacts = m != 1;
  }
  return named(std::move(c), "GroupMasks");
}

Case no_self_contacts() {
  Case c;
  for (uint32_t m = 0; m < 3; ++m) {
    const Case part = soup(30 + m, 250, 1, 0.12, 0.03);
    add_mesh(c, part.meshes[0].triangles, part.start[0], part.end[0]);
    c.meshes[m].self_contacts = false;
  }
  return named(std::move(c), "NoSelfContacts");
}

// All vertices fly through the whole domain: every swept box is large.
Case fast_motion() {
  Case c = soup(40, 300, 1, 0.05, 0);
  Random random(41);
  for (size_t v = 0; v < c.end[0].size(); v += 3) {
    const Vec3d step = random.point(4);
    for (size_t i = v; i < v + 3; ++i)
      for (int k = 0; k < 3; ++k) c.end[0][i][k] += step[k];
  }
  return named(std::move(c), "FastMotion");
}

/// Vertices of `count` triples as a mesh without elements.
void add_vertices(Case& c, uint32_t seed, uint32_t count, double side, double size, double step) {
  const Case part = soup(seed, count, side, size, step);
  add_mesh(c, {}, part.start[0], part.end[0]);
}

void add_hairs(Case& c, uint32_t seed, uint32_t count, double side, double size, double step) {
  add_vertices(c, seed, count, side, size, step);
  for (uint32_t v = 0; v < 3 * count; v += 3)
    c.meshes.back().edges.insert(c.meshes.back().edges.end(), {{v, v + 1}, {v + 2, v + 1}});
}

/// But for the last vertex, which is in no element.
void add_particles(Case& c, uint32_t seed, uint32_t count, double side, double size, double step) {
  add_vertices(c, seed, count, side, size, step);
  for (uint32_t v = 3 * count - 1; v-- > 0;) c.meshes.back().points.push_back(v);
}

/// A triangle, a loose edge and a point of each three triples.
void add_mixed(Case& c, uint32_t seed, uint32_t count, double side, double size, double step) {
  add_vertices(c, seed, count, side, size, step);
  MeshSpec& mesh = c.meshes.back();
  for (uint32_t v = 0; v + 5 < 3 * count; v += 6) {
    mesh.triangles.push_back({v, v + 1, v + 2});
    mesh.edges.push_back({v + 4, v + 3});
    mesh.points.push_back(v + 5);
  }
  // A triangle's edge, a loose one the other way round, one from a triangle to a point; a corner, an end, a point.
  mesh.edges.insert(mesh.edges.end(), {{1, 0}, mesh.edges[1], {mesh.edges[0][1], mesh.edges[0][0]}, {6, 5}});
  mesh.points.insert(mesh.points.end(), {2, 9, 11, 17, 17});
}

Case hairs() {
  Case c;
  add_hairs(c, 50, 400, 1, 0.1, 0.03);
  return named(std::move(c), "Hairs");
}

Case particles() {
  Case c;
  add_particles(c, 51, 300, 1, 0.1, 0.05);
  add_particles(c, 52, 200, 1, 0.1, 0);  // at rest: no box has an extent
  return named(std::move(c), "Particles");
}

Case particles_at_rest() {
  Case c;
  add_particles(c, 53, 300, 0.2, 0.1, 0);
  return named(on_integers(std::move(c)), "ParticlesAtOnePoint");
}

Case all_at_one_point() { return one_mesh("AllAtOnePoint", Positions(90, Vec3d{0.1, 0.2, 0.3})); }

Case one_triangle() { return one_mesh("OneTriangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}); }

}  // namespace

Case soup(uint32_t seed, uint32_t count, double side, double size, double step, const Vec3d& centre) {
  Random random(seed);
  Positions start, end;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3d middle = random.point(side, centre);
    for (int k = 0; k < 3; ++k) {
      start.push_back(random.point(size, middle));
      end.push_back(random.point(step, start.back()));
    }
  }
  return one_mesh("Soup", std::move(start), std::move(end));
}

Case loose_soup(uint32_t seed, uint32_t count, double side, double size, double step) {
  Case c;
  add_mixed(c, seed, 2 * count, side, size, step);
  add_hairs(c, seed + 1, count / 2 + 1, side, size, step);
  add_particles(c, seed + 2, count / 3 + 1, side, size, step);
  return named(std::move(c), "LooseSoup");
}

Case loosened(Case c) {
  for (MeshSpec& mesh : c.meshes) {
    const auto triangles = std::exchange(mesh.triangles, {});
    for (size_t i = 0; i < triangles.size(); ++i) {
      const auto& t = triangles[i];
      if (i % 3 == 0) mesh.triangles.push_back(t);
      if (i % 3 == 1) mesh.edges.insert(mesh.edges.end(), {{t[0], t[1]}, {t[1], t[2]}});
      if (i % 3 == 2) mesh.points.insert(mesh.points.end(), t.begin(), t.end());
    }
  }
  return c;
}

Case on_integers(Case c) {
  for (auto* all : {&c.start, &c.end})
    for (Positions& positions : *all)
      for (Vec3d& p : positions)
        for (double& x : p) x = std::round(x);
  return c;
}

Case crowd() { return soup(70, 3500, 0.01, 0.5, 0.3); }

Case far_apart(uint32_t triangles) {
  std::mt19937_64 random(71);
  const auto number = [&] {
    const int exponent = static_cast<int>(random() % 1900) - 1000;
    return std::ldexp(static_cast<double>(random() % 2000) / 1000 - 1, exponent);
  };
  Case c = soup(71, triangles, 1, 0.5, 0.3);
  for (Positions* positions : {&c.start[0], &c.end[0]})
    for (auto& p : *positions) p = {number(), number(), number()};
  return c;
}

std::vector<Case> adversarial_cases() {
  return {touching_on_lattice(),
          flat_plane(),
          named(soup(1, 300, 1e-3, 1, 0.01), "AllInOneCell"),
          one_huge_triangle(),
          anisotropic(),
          named(soup(2, 600, 1, 0.1, 0.02, {1e6, -2e6, 3e6}), "FarFromOrigin"),
          named(soup(3, 600, 1, 0.1, 0.02, {1e3, 1e3, -1e3}), "OffOrigin"),
          mixed_scale(),
          duplicated_vertices(),
          fan(),
          named(soup(4, 2000, 1, 0.05, 0.02), "RandomSoup"),
          named(soup(5, 500, 1e-20, 1e-21, 1e-22), "TinyUnits"),
          named(soup(6, 500, 1e15, 1e14, 1e13), "HugeUnits"),
          static_obstacles(),
          group_masks(),
          no_self_contacts(),
          fast_motion(),
          all_at_one_point(),
          one_triangle(),
          loose_soup(60, 400, 1, 0.12, 0.03),
          hairs(),
          particles(),
          particles_at_rest()};
}

}  // namespace collided::test
