// glTF 2.0 and GLB: the meshes that the nodes of the scene place, joined into one. Vertices that exporters split for
// their normals or texture coordinates are welded within each mesh.

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "client/scenes/mesh_files/gltf_document.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"
#include "client/scenes/mesh_files/transform.hpp"

namespace collided::scenes {

namespace {

template <size_t kCount>
std::array<double, kCount> numbers_of(const Json& node, const char* key, std::array<double, kCount> otherwise,
                                      const std::string& place) {
  const auto found = node.find(key);
  if (found == node.end()) return otherwise;
  bool is_fine = found->is_array() && found->size() == kCount;
  for (size_t i = 0; is_fine && i < kCount; ++i) {
    is_fine = (*found)[i].is_number();
    if (is_fine) otherwise[i] = (*found)[i].template get<double>();
    is_fine = is_fine && std::isfinite(otherwise[i]);
  }
  if (!is_fine) fail(place, std::string(key) + " must be " + std::to_string(kCount) + " numbers");
  return otherwise;
}

Transform transform_of(const Json& node, const std::string& place) {
  if (node.contains("matrix")) {
    const auto columns = numbers_of<16>(node, "matrix", {}, place);
    Transform out;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) out.m[4 * r + c] = columns[4 * c + r];
    return out;
  }
  const auto t = numbers_of<3>(node, "translation", {0, 0, 0}, place);
  const auto q = numbers_of<4>(node, "rotation", {0, 0, 0, 1}, place);
  const auto s = numbers_of<3>(node, "scale", {1, 1, 1}, place);
  const auto [x, y, z, w] = q;
  const double squared = x * x + y * y + z * z + w * w;  // exporters round, so that it is not quite 1
  if (!(squared > 0 && std::isfinite(squared))) fail(place, "'rotation' is no quaternion: its length is 0, or infinite");
  const double n = 2 / squared;
  return {{(1 - n * (y * y + z * z)) * s[0], n * (x * y - z * w) * s[1], n * (x * z + y * w) * s[2], t[0],
           n * (x * y + z * w) * s[0], (1 - n * (x * x + z * z)) * s[1], n * (y * z - x * w) * s[2], t[1],
           n * (x * z - y * w) * s[0], n * (y * z + x * w) * s[1], (1 - n * (x * x + y * y)) * s[2], t[2]}};
}

class GltfReader {
 public:
  GltfReader(std::string_view text, const std::string& file)
      : expansion_(file, text.size()),
        document_(text, file, expansion_),
        file_(file),
        placer_(mesh_, expansion_, file, true),
        is_visited_(document_.size("nodes")) {}

  RawMesh run() {
    for (const uint64_t root : roots()) visit(root, {}, 0);
    if (is_visited_.empty())  // a library of meshes that no node places
      for (uint64_t i = 0; i < document_.size("meshes"); ++i) place(i, {});
    placer_.add_notes();
    for (const std::string& what : ignored_) mesh_.notes.push_back("ignored " + what);
    return std::move(mesh_);
  }

 private:
  uint64_t index(const Json& value, const std::string& place) const {
    if (!value.is_number_unsigned()) fail(place, "must list whole numbers");
    return value.get<uint64_t>();
  }

  /// Returns the nodes of the default scene. Without any scene these are all nodes without a parent.
  std::vector<uint64_t> roots() const {
    std::vector<uint64_t> out;
    if (document_.size("scenes") > 0) {
      const uint64_t scene = document_.whole(document_.root(), "scene", file_, 0);
      const std::string place = document_.place("scene", scene);
      for (const Json& node : document_.list(document_.element("scenes", scene), "nodes", place))
        out.push_back(index(node, place + ": nodes"));
      return out;
    }
    std::set<uint64_t> children;
    for (uint64_t i = 0; i < is_visited_.size(); ++i)
      for (const Json& child : children_of(i)) children.insert(index(child, document_.place("node", i) + ": children"));
    for (uint64_t i = 0; i < is_visited_.size(); ++i)
      if (!children.contains(i)) out.push_back(i);
    return out;
  }
  const Json& children_of(uint64_t node) const {
    return document_.list(document_.element("nodes", node), "children", document_.place("node", node));
  }

  void visit(uint64_t node, const Transform& parent, int depth) {
    const Json& spec = document_.element("nodes", node);
    const std::string at = document_.place("node", node);
    if (is_visited_[node]) fail(at, "is reached twice; nodes must be trees");
    is_visited_[node] = true;
    if (depth == kMaxNodeDepth) fail(at, "nodes are nested deeper than " + std::to_string(kMaxNodeDepth));
    const Transform own = transform_of(spec, at), here = own == Transform() ? parent : parent * own;
    if (spec.contains("skin")) ignored_.insert("skins: meshes are as they were modelled");
    if (spec.contains("mesh"))  // a skin replaces its node's transform
      place(document_.whole(spec, "mesh", at), spec.contains("skin") ? Transform() : here);
    for (const Json& child : children_of(node)) visit(index(child, at + ": children"), here, depth + 1);
  }

  void place(uint64_t mesh, const Transform& transform) {
    const auto [at, is_new] = parts_.try_emplace(mesh);
    if (is_new) at->second = read_part(mesh);
    placer_.place(at->second, transform, is_new);
  }

  RawMesh read_part(uint64_t mesh) {
    RawMesh part;
    Known known;
    const std::string at = document_.place("mesh", mesh);
    uint64_t number = 0;
    for (const Json& primitive : document_.list(document_.element("meshes", mesh), "primitives", at)) {
      const std::string here = at + ": primitive " + std::to_string(number++);
      if (!primitive.is_object()) fail(here, "must be an object");
      add_primitive(primitive, here, known, part);
    }
    return part;
  }

  /// The first vertex and the number of vertices of accessors, which the primitives of a mesh may share.
  using Known = std::map<uint64_t, std::pair<uint32_t, uint32_t>>;

  std::pair<uint32_t, uint32_t> vertices_of(uint64_t accessor, Known& known, RawMesh& part) {
    const auto found = known.find(accessor);
    if (found != known.end()) return found->second;
    const std::vector<Vec3d> positions = document_.positions(accessor);
    const size_t first = part.positions.size();
    if (first + positions.size() > UINT32_MAX) fail(file_, "has more than 4294967295 vertices");
    part.positions.insert(part.positions.end(), positions.begin(), positions.end());
    return known[accessor] = {static_cast<uint32_t>(first), static_cast<uint32_t>(positions.size())};
  }

  void add_primitive(const Json& primitive, const std::string& at, Known& known, RawMesh& part) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) fail(at, "attributes must be an object");
    if (primitive.contains("targets")) ignored_.insert("morph targets");
    const auto [first, count] = vertices_of(document_.whole(*attributes, "POSITION", at), known, part);
    const uint64_t mode = document_.whole(primitive, "mode", at, 4);
    const bool is_strip = mode == 5 || mode == 6, is_line = mode == 2 || mode == 3;
    const uint64_t corners_each = is_strip ? 3 : is_line ? 2 : 1;
    std::vector<uint32_t> indices;
    if (primitive.contains("indices"))
      indices = document_.indices(document_.whole(primitive, "indices", at), corners_each);
    else
      expansion_.count(corners_each * count);
    for (uint32_t i = 0; i < count && !primitive.contains("indices"); ++i) indices.push_back(i);
    for (uint32_t& i : indices) {
      if (i >= count) fail(at, "vertex index " + std::to_string(i) + " is out of range; " + vertices_there(count));
      i += first;
    }
    add_elements(mode, indices, part, at);
  }

  static void add_elements(uint64_t mode, const std::vector<uint32_t>& v, RawMesh& part, const std::string& at) {
    const auto check_multiple = [&](size_t of) {
      if (v.size() % of != 0)
        fail(at, "has " + count_text(v.size(), "index", "indices") + ", which is no multiple of " + std::to_string(of));
    };
    const auto add_edges = [&](size_t step) {
      for (size_t i = 1; i < v.size(); i += step) part.edges.push_back({v[i - 1], v[i]});
    };
    switch (mode) {
      case 0:
        part.points.insert(part.points.end(), v.begin(), v.end());
        return;
      case 1:
        check_multiple(2);
        return add_edges(2);
      case 2:
        add_edges(1);
        if (v.size() > 2) part.edges.push_back({v.back(), v.front()});
        return;
      case 3:
        return add_edges(1);
      case 4:
        check_multiple(3);
        for (size_t i = 0; i < v.size(); i += 3) part.add_face({v[i], v[i + 1], v[i + 2]});
        return;
      case 5:
        return part.add_strip(v);
      case 6:
        return part.add_fan(v);
      default:
        fail(at, "mode " + std::to_string(mode) + " is none of glTF's");
    }
  }

  Expansion expansion_;
  GltfDocument document_;
  const std::string& file_;
  RawMesh mesh_;
  MeshPlacer placer_;
  std::vector<bool> is_visited_;
  std::map<uint64_t, RawMesh> parts_;  ///< the meshes that were placed
  std::set<std::string> ignored_;
};

}  // namespace

RawMesh read_gltf(std::string_view text, const std::string& file) { return GltfReader(text, file).run(); }

}  // namespace collided::scenes
