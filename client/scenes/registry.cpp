// Names of the procedural scenes.

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "client/scenes/families.hpp"

namespace collided::scenes {

namespace {

constexpr double kMinScale = 0.02, kMaxScale = 30;

struct Entry {
  SceneInfo info;
  ScenePtr (*make)(double scale);
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = {
      {{"funnel", "a cloth falls folding through a funnel; 18,504 triangles"}, make_funnel},
      {{"cloth_ball", "a cloth wraps and twists around a turning ball; 91,872 triangles"}, make_cloth_ball},
      {{"flamenco", "a dancer spins in a skirt of six ruffled layers; 48,960 triangles"}, make_flamenco},
      {{"nbody", "240 spheres close in on five cones; 146,000 triangles"}, make_nbody},
      {{"reef_knot", "two ribbons are tied tighter and tighter; 19,992 triangles"}, make_reef_knot},
      {{"multiscale_knots", "four reef knots, each an eighth of the one before; 79,968 triangles"},
       [](double scale) { return make_multiscale_knots(scale, 8); }},
      {{"graded_sheets", "four sheets with triangles graded towards one edge; 180,000 triangles"}, make_graded_sheets},
      {{"touching_boxes", "a lattice of cubes that share whole faces; 20,736 triangles"}, make_touching_boxes},
      {{"one_cell", "a dense swarm in a tiny part of a huge domain; 4,004 triangles"}, make_one_cell},
      {{"huge_triangle", "one triangle as large as the domain sweeps a fine sheet; 20,001 triangles"},
       make_huge_triangle},
      {{"anisotropic", "two crossing families of slivers 1 : 1000; 4,000 triangles"}, make_anisotropic},
  };
  return list;
}

const std::vector<Entry>& variants() {
  static const std::vector<Entry> list = {
      {{"multiscale_knots_1", "multiscale_knots, but all four of one size; 79,968 triangles"},
       [](double scale) { return make_multiscale_knots(scale, 1); }},
      {{"multiscale_knots_2", "multiscale_knots, but each half of the one before; 79,968 triangles"},
       [](double scale) { return make_multiscale_knots(scale, 2); }},
      {{"multiscale_knots_4", "multiscale_knots, but each a quarter of the one before; 79,968 triangles"},
       [](double scale) { return make_multiscale_knots(scale, 4); }},
  };
  return list;
}

const Entry& entry_of(const std::string& name, double scale) {
  if (!(scale >= kMinScale && scale <= kMaxScale)) {
    std::ostringstream text;  // unlike std::to_string, not 0.000000 for a small one
    text << "scale is " << scale << "; it must be in [0.02, 30]";
    throw std::invalid_argument(text.str());
  }
  std::string known;
  for (const auto* list : {&entries(), &variants()})
    for (const Entry& entry : *list) {
      if (entry.info.name == name) return entry;
      known += (known.empty() ? "" : ", ") + entry.info.name;
    }
  throw std::invalid_argument("scene '" + name + "' is not known; the scenes are " + known);
}

std::vector<SceneInfo> infos(const std::vector<Entry>& list) {
  std::vector<SceneInfo> out;
  for (const Entry& entry : list) out.push_back(entry.info);
  return out;
}

}  // namespace

std::vector<SceneInfo> list_scenes() { return infos(entries()); }
std::vector<SceneInfo> list_variants() { return infos(variants()); }

void check_scene(const std::string& name, double scale) { entry_of(name, scale); }

std::unique_ptr<Scene> make_scene(const std::string& name, double scale) { return entry_of(name, scale).make(scale); }

}  // namespace collided::scenes
