// COLLADA (DAE): the geometries that the nodes of the scene place, joined into one mesh. The file's unit and upward
// axis are not applied: positions are those that the file has.

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <pugixml.hpp>
#include <set>

#include "client/scenes/mesh_files/mesh_text.hpp"
#include "client/scenes/mesh_files/transform.hpp"

namespace collided::scenes {

namespace {

using pugi::xml_node;

std::string_view text_of(const xml_node& node) { return node.child_value(); }

/// What errors call an element: its tag and its id or name.
std::string label_of(const xml_node& node) {
  const char* const id = node.attribute("id") ? node.attribute("id").value() : node.attribute("name").value();
  return *id ? std::string(node.name()) + " '" + std::string(id).substr(0, 80) + "'" : std::string(node.name());
}

class DaeReader {
 public:
  DaeReader(std::string_view text, const std::string& file) : file_(file), placer_(mesh_, file, false) {
    if (text.find("<!DOCTYPE") != std::string_view::npos) fail(file, "has a DOCTYPE, which COLLADA has not");
    const pugi::xml_parse_result result = document_.load_buffer(text.data(), text.size());
    if (!result) {
      const std::string_view before = text.substr(0, static_cast<size_t>(std::max<std::ptrdiff_t>(result.offset, 0)));
      fail(file + ":" + std::to_string(1 + std::count(before.begin(), before.end(), '\n')),
           "is not well-formed XML, or is cut off");
    }
    root_ = document_.child("COLLADA");
    if (!root_) fail(file, "has no element COLLADA");
    collect_ids();
  }

  RawMesh run() {
    const xml_node instance = root_.child("scene").child("instance_visual_scene");
    const xml_node scene = instance ? target(instance) : root_.child("library_visual_scenes").child("visual_scene");
    if (scene)
      for (const xml_node& node : scene.children("node")) visit(node, {}, 0);
    else
      for (const xml_node& library : root_.children("library_geometries"))
        for (const xml_node& geometry : library.children("geometry")) place(geometry, {});
    placer_.add_notes();
    for (const std::string& note : notes_) mesh_.notes.push_back(note);
    return std::move(mesh_);
  }

 private:
  void collect_ids() {
    std::vector<std::pair<xml_node, int>> open{{root_, 0}};
    while (!open.empty()) {
      const auto [node, depth] = open.back();
      open.pop_back();
      if (depth > kMaxNodeDepth) fail(file_, "elements are nested deeper than " + std::to_string(kMaxNodeDepth));
      if (const auto id = node.attribute("id")) ids_.try_emplace(id.value(), node);
      for (const xml_node& child : node.children()) open.emplace_back(child, depth + 1);
    }
  }

  std::string place_of(const xml_node& node) const { return file_ + ": " + label_of(node); }

  /// The element that a reference names.
  xml_node target(const xml_node& reference, const char* attribute = "url") const {
    const std::string url = reference.attribute(attribute).value();
    const auto found = url.starts_with('#') ? ids_.find(url.substr(1)) : ids_.end();
    if (found == ids_.end()) fail(place_of(reference), "'" + url.substr(0, 80) + "' is not in the file");
    return found->second;
  }

  template <class T>
  std::vector<T> numbers(const xml_node& node) const {
    std::vector<T> out;
    std::string_view text = text_of(node);
    const auto place = [&] { return place_of(node); };
    for (std::string_view line = next_line(text);; line = next_line(text)) {
      for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
        out.push_back(parse_number<T>(word, place));
      if (text.empty()) return out;
    }
  }

  std::vector<double> numbers(const xml_node& node, size_t count) const {
    std::vector<double> out = numbers<double>(node);
    if (out.size() != count)
      fail(place_of(node), "has " + count_text(out.size(), "number") + "; it needs " + std::to_string(count));
    for (const double x : out)
      if (!std::isfinite(x)) fail(place_of(node), "a number is not finite");
    return out;
  }

  static Transform rotation(const std::vector<double>& r) {
    const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    if (length == 0) return {};
    const double angle = r[3] * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle), t = 1 - c;
    const double x = r[0] / length, y = r[1] / length, z = r[2] / length;
    return {{t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0, t * x * y + s * z, t * y * y + c,
             t * y * z - s * x, 0, t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0}};
  }

  /// The product of a node's transforms, in their order.
  Transform transform_of(const xml_node& node) const {
    Transform out;
    for (const xml_node& child : node.children()) {
      const std::string_view name = child.name();
      if (name == "matrix") {
        const auto n = numbers(child, 16);
        Transform matrix;
        std::copy_n(n.begin(), 12, matrix.m.begin());
        out = out * matrix;
      } else if (name == "translate") {
        const auto n = numbers(child, 3);
        out = out * Transform{{1, 0, 0, n[0], 0, 1, 0, n[1], 0, 0, 1, n[2]}};
      } else if (name == "scale") {
        const auto n = numbers(child, 3);
        out = out * Transform{{n[0], 0, 0, 0, 0, n[1], 0, 0, 0, 0, n[2], 0}};
      } else if (name == "rotate") {
        out = out * rotation(numbers(child, 4));
      } else if (name == "skew" || name == "lookat") {
        fail(place_of(node), "the transform '" + std::string(name) + "' is not read");
      }
    }
    return out;
  }

  void visit(const xml_node& node, const Transform& parent, int depth) {
    if (depth > kMaxNodeDepth) fail(place_of(node), "nodes are nested deeper than " + std::to_string(kMaxNodeDepth));
    if (++visits_ > kMaxVisits) fail(file_, "nodes are instanced more than " + std::to_string(kMaxVisits) + " times");
    const Transform own = transform_of(node), here = own == Transform() ? parent : parent * own;
    for (const xml_node& child : node.children()) {
      const std::string_view name = child.name();
      if (name == "node") visit(child, here, depth + 1);
      if (name == "instance_node") visit(target(child), here, depth + 1);
      if (name == "instance_geometry") place(target(child), here);
      if (name == "instance_controller") place(skinned(target(child)), here);
    }
  }

  /// The geometry behind a controller, as it was modelled.
  xml_node skinned(xml_node controller) {
    notes_.insert("ignored skins: meshes are as they were modelled");
    for (int depth = 0; depth < kMaxNodeDepth; ++depth) {
      const xml_node skin = controller.child("skin") ? controller.child("skin") : controller.child("morph");
      controller = target(skin, "source");
      if (std::string_view(controller.name()) == "geometry") return controller;
    }
    fail(place_of(controller), "its controllers go in circles");
  }

  void place(const xml_node& geometry, const Transform& transform) {
    const xml_node mesh = geometry.child("mesh");
    if (!mesh) {
      notes_.insert("ignored a geometry that is no mesh");
      return;
    }
    placer_.place(transform, !placed_.insert(geometry.attribute("id").value()).second, [&] { add_mesh(mesh); });
  }

  void add_mesh(const xml_node& mesh) {
    const xml_node vertices = mesh.child("vertices");
    xml_node source;
    for (const xml_node& input : vertices.children("input"))
      if (std::string_view(input.attribute("semantic").value()) == "POSITION") source = target(input, "source");
    if (!source) fail(place_of(mesh.parent()), "its vertices have no POSITION");
    first_ = static_cast<uint32_t>(mesh_.positions.size());
    add_positions(source);
    for (const xml_node& child : mesh.children()) add_primitive(child);
  }

  uint64_t whole(const xml_node& node, const char* attribute, uint64_t otherwise) const {
    const auto found = node.attribute(attribute);
    return found ? parse_number<uint64_t>(found.value(), place_of(node)) : otherwise;
  }

  void add_positions(const xml_node& source) {
    const xml_node accessor = source.child("technique_common").child("accessor");
    const xml_node array = target(accessor, "source");
    const std::vector<double> numbers = this->numbers<double>(array);
    const uint64_t count = whole(accessor, "count", 0), stride = whole(accessor, "stride", 1);
    const uint64_t offset = whole(accessor, "offset", 0);
    if (stride < 3) fail(place_of(source), "stride is " + std::to_string(stride) + "; positions need 3");
    const uint64_t left = offset < numbers.size() ? numbers.size() - offset : 0;
    if (count > 0 && (left < 3 || count - 1 > (left - 3) / stride))
      fail(place_of(source), std::to_string(count) + " positions do not fit in " + count_text(left, "number"));
    for (uint64_t i = 0; i < count; ++i) {
      const double* const at = &numbers[offset + i * stride];
      if (!std::isfinite(at[0] + at[1] + at[2]))
        fail(place_of(source), "position " + std::to_string(i) + " is not finite");
      mesh_.positions.push_back({at[0], at[1], at[2]});
    }
  }

  /// Returns the vertex indices among all indices of a primitive.
  std::vector<uint32_t> vertices_of(const xml_node& primitive, const xml_node& p) const {
    uint64_t stride = 1, offset = 0;
    for (const xml_node& input : primitive.children("input")) {
      const uint64_t at = whole(input, "offset", 0);
      if (at > 255) fail(place_of(input), "offset is " + std::to_string(at) + "; the limit is 255");
      stride = std::max(stride, at + 1);
      if (std::string_view(input.attribute("semantic").value()) == "VERTEX") offset = at;
    }
    const std::vector<uint64_t> all = numbers<uint64_t>(p);
    const size_t count = mesh_.positions.size() - first_;
    std::vector<uint32_t> out;
    for (size_t i = offset; i < all.size(); i += stride) {
      if (all[i] >= count)
        fail(place_of(primitive),
             "vertex index " + std::to_string(all[i]) + " is out of range; " + vertices_there(count));
      out.push_back(first_ + static_cast<uint32_t>(all[i]));
    }
    return out;
  }

  void add_polylist(const xml_node& polylist) {
    const std::vector<uint32_t> v = vertices_of(polylist, polylist.child("p"));
    size_t at = 0;
    for (const uint64_t count : numbers<uint64_t>(polylist.child("vcount"))) {
      if (count > v.size() - at) fail(place_of(polylist), "is cut off: vcount has more corners than p");
      mesh_.add_face(&v[at], count);
      at += count;
    }
  }

  void add_primitive(const xml_node& node) {
    const std::string_view name = node.name();
    if (name == "polylist") return add_polylist(node);
    if (name == "polygons" && node.child("ph")) fail(place_of(node), "polygons with holes are not read");
    for (const xml_node& p : node.children("p")) {
      const std::vector<uint32_t> v = vertices_of(node, p);
      if (name == "triangles" && v.size() % 3 != 0)
        fail(place_of(node), "has " + count_text(v.size(), "corner") + ", which is no multiple of 3");
      for (size_t i = 0; name == "triangles" && i < v.size(); i += 3) mesh_.add_face({v[i], v[i + 1], v[i + 2]});
      if (name == "polygons") mesh_.add_face(v.data(), v.size());
      if (name == "tristrips") mesh_.add_strip(v);
      if (name == "trifans") mesh_.add_fan(v);
      for (size_t i = 1; name == "lines" && i < v.size(); i += 2) mesh_.edges.push_back({v[i - 1], v[i]});
      for (size_t i = 1; name == "linestrips" && i < v.size(); ++i) mesh_.edges.push_back({v[i - 1], v[i]});
    }
  }

  static constexpr uint64_t kMaxVisits = 250'000;

  const std::string& file_;
  pugi::xml_document document_;
  xml_node root_;
  std::map<std::string, xml_node, std::less<>> ids_;
  RawMesh mesh_;
  MeshPlacer placer_;
  std::set<std::string> placed_, notes_;
  uint32_t first_ = 0;  ///< vertex of the geometry that is being added
  uint64_t visits_ = 0;
};

}  // namespace

RawMesh read_dae(std::string_view text, const std::string& file) { return DaeReader(text, file).run(); }

}  // namespace collided::scenes
