// COLLADA (DAE): the geometries that the nodes of the scene place, joined into one mesh. The file's unit and upward
// axis are not applied: positions are those that the file has.

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "client/scenes/mesh_files/mesh_text.hpp"
#include "client/scenes/mesh_files/transform.hpp"
#include "client/scenes/mesh_files/collada/xml.hpp"

namespace collided::scenes {

namespace {

/// Returns an element's name in errors: its tag and its id or name.
std::string label_of(const XmlElement& element) {
  const std::string id = element.value("id"), label = id.empty() ? element.value("name") : id;
  return element.name + (label.empty() ? "" : " '" + label.substr(0, 80) + "'");
}

/// Calls visit(child) for the children of this name.
template <class Visit>
void for_each_child(const XmlElement& element, std::string_view name, const Visit& visit) {
  for (const XmlElement* child : element.children)
    if (child->name == name) visit(*child);
}

class DaeReader {
 public:
  DaeReader(std::string_view text, const std::string& file)
      : file_(file), expansion_(file, text.size()), placer_(mesh_, expansion_, file, false) {
    if (text.find("<!DOCTYPE") != std::string_view::npos) fail(file, "has a DOCTYPE, which COLLADA has not");
    document_ = parse_xml(text, file, kMaxNodeDepth);
    if (root().name != "COLLADA") fail(file, "has no element COLLADA");
    for (const XmlElement& element : document_)
      if (const std::string* id = element.attribute("id")) ids_.try_emplace(*id, &element);
  }

  RawMesh run() {
    const XmlElement* const of_scene = root().child("scene");
    const XmlElement* const instance = of_scene ? of_scene->child("instance_visual_scene") : nullptr;
    const XmlElement* const library = root().child("library_visual_scenes");
    const XmlElement* const first = library ? library->child("visual_scene") : nullptr;
    if (const XmlElement* const scene = instance ? target(*instance) : first)
      for_each_child(*scene, "node", [&](const XmlElement& node) { visit(node, {}, 0); });
    else
      for_each_child(root(), "library_geometries", [&](const XmlElement& geometries) {
        for_each_child(geometries, "geometry", [&](const XmlElement& geometry) { place(geometry, {}); });
      });
    placer_.add_notes();
    for (const std::string& note : notes_) mesh_.notes.push_back(note);
    return std::move(mesh_);
  }

 private:
  /// A node whose references are resolved.
  struct Node {
    Transform own;
    struct Item {
      const XmlElement* target;
      bool is_node;  ///< else a geometry
    };
    std::vector<Item> items;
  };

  const XmlElement& root() const { return document_.front(); }
  std::string place_of(const XmlElement& element) const { return file_ + ": " + label_of(element); }

  /// The element that a reference names.
  const XmlElement* target(const XmlElement& reference, const char* attribute = "url") const {
    const std::string url = reference.value(attribute);
    const auto found = url.starts_with('#') ? ids_.find(std::string_view(url).substr(1)) : ids_.end();
    if (found == ids_.end()) fail(place_of(reference), "'" + url.substr(0, 80) + "' is not in the file");
    return found->second;
  }

  template <class T>
  std::vector<T> numbers(const XmlElement& element) const {
    std::vector<T> out;
    std::string_view text = element.text;
    const auto place = [&] { return place_of(element); };
    while (!text.empty()) {
      std::string_view line = next_line(text);
      for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
        out.push_back(parse_number<T>(word, place));
    }
    return out;
  }

  std::vector<double> numbers(const XmlElement& element, size_t count) const {
    std::vector<double> out = numbers<double>(element);
    if (out.size() != count)
      fail(place_of(element), "has " + count_text(out.size(), "number") + "; it needs " + std::to_string(count));
    for (const double x : out)
      if (!std::isfinite(x)) fail(place_of(element), "a number is not finite");
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
  Transform transform_of(const XmlElement& node) const {
    Transform out;
    for (const XmlElement* child : node.children) {
      const std::string& name = child->name;
      if (name == "matrix") {
        const auto n = numbers(*child, 16);
        Transform matrix;
        std::copy_n(n.begin(), 12, matrix.m.begin());
        out = out * matrix;
      } else if (name == "translate") {
        const auto n = numbers(*child, 3);
        out = out * Transform{{1, 0, 0, n[0], 0, 1, 0, n[1], 0, 0, 1, n[2]}};
      } else if (name == "scale") {
        const auto n = numbers(*child, 3);
        out = out * Transform{{n[0], 0, 0, 0, 0, n[1], 0, 0, 0, 0, n[2], 0}};
      } else if (name == "rotate") {
        out = out * rotation(numbers(*child, 4));
      } else if (name == "skew" || name == "lookat") {
        fail(place_of(node), "the transform '" + name + "' is not read");
      }
    }
    return out;
  }

  /// Nodes may be visited often, so that each is read once.
  const Node& read(const XmlElement& element) {
    const auto [at, is_new] = nodes_.try_emplace(&element);
    Node& node = at->second;
    if (!is_new) return node;
    node.own = transform_of(element);
    for (const XmlElement* child : element.children) {
      if (child->name == "node") node.items.push_back({child, true});
      if (child->name == "instance_node") node.items.push_back({target(*child), true});
      if (child->name == "instance_geometry") node.items.push_back({target(*child), false});
      if (child->name == "instance_controller") node.items.push_back({skinned(target(*child)), false});
    }
    return node;
  }

  void visit(const XmlElement& element, const Transform& parent, int depth) {
    if (depth > kMaxNodeDepth)
      fail(place_of(element), "nodes are nested deeper than " + std::to_string(kMaxNodeDepth));
    expansion_.count_node();
    const Node& node = read(element);
    const Transform here = node.own == Transform() ? parent : parent * node.own;
    for (const Node::Item& item : node.items) {
      if (item.is_node)
        visit(*item.target, here, depth + 1);
      else
        expansion_.count_node(), place(*item.target, here);
    }
  }

  /// The geometry behind a controller, as it was modelled.
  const XmlElement* skinned(const XmlElement* controller) {
    notes_.insert("ignored skins: meshes are as they were modelled");
    std::vector<const XmlElement*> path{controller};
    while (!geometries_.contains(path.back())) {
      const XmlElement* const at = path.back();
      const XmlElement* const skin = at->child("skin") ? at->child("skin") : at->child("morph");
      if (!skin) fail(place_of(*at), "has no skin and no morph");
      const XmlElement* const source = target(*skin, "source");
      if (source->name == "geometry")
        geometries_[at] = source;
      else if (path.size() == kMaxNodeDepth)
        fail(place_of(*controller), "its controllers go in circles");
      else
        path.push_back(source);
    }
    const XmlElement* const geometry = geometries_[path.back()];
    for (const XmlElement* one : path) geometries_[one] = geometry;
    return geometry;
  }

  void place(const XmlElement& geometry, const Transform& transform) {
    const XmlElement* const mesh = geometry.child("mesh");
    if (!mesh) {
      notes_.insert("ignored a geometry that is no mesh");
      return;
    }
    const auto [at, is_new] = parts_.try_emplace(&geometry);
    if (is_new) read_part(geometry, *mesh, at->second);
    placer_.place(at->second, transform, is_new);
  }

  void read_part(const XmlElement& geometry, const XmlElement& mesh, RawMesh& part) {
    const XmlElement* source = nullptr;
    if (const XmlElement* const vertices = mesh.child("vertices"))
      for_each_child(*vertices, "input", [&](const XmlElement& input) {
        if (input.value("semantic") == "POSITION") source = target(input, "source");
      });
    if (!source) fail(place_of(geometry), "its vertices have no POSITION");
    add_positions(*source, part);
    for (const XmlElement* child : mesh.children) add_primitive(*child, part);
  }

  uint64_t whole(const XmlElement& element, const char* attribute, uint64_t otherwise) const {
    const std::string* const found = element.attribute(attribute);
    return found ? parse_number<uint64_t>(*found, [&] { return place_of(element); }) : otherwise;
  }

  /// The numbers of an array, which several sources may share.
  const std::vector<double>& array(const XmlElement& element) {
    const auto [at, is_new] = arrays_.try_emplace(&element);
    if (is_new) at->second = numbers<double>(element);
    return at->second;
  }

  void add_positions(const XmlElement& source, RawMesh& part) {
    const XmlElement* const technique = source.child("technique_common");
    const XmlElement* const accessor = technique ? technique->child("accessor") : nullptr;
    if (!accessor) fail(place_of(source), "has no accessor");
    const std::vector<double>& numbers = array(*target(*accessor, "source"));
    const uint64_t count = whole(*accessor, "count", 0), stride = whole(*accessor, "stride", 1);
    const uint64_t offset = whole(*accessor, "offset", 0);
    if (stride < 3) fail(place_of(source), "stride is " + std::to_string(stride) + "; positions need 3");
    const uint64_t left = offset < numbers.size() ? numbers.size() - offset : 0;
    if (count > 0 && (left < 3 || count - 1 > (left - 3) / stride))
      fail(place_of(source), std::to_string(count) + " positions do not fit in " + count_text(left, "number"));
    expansion_.count(count);
    for (uint64_t i = 0; i < count; ++i) {
      const double* const at = &numbers[offset + i * stride];
      if (!(std::isfinite(at[0]) && std::isfinite(at[1]) && std::isfinite(at[2])))
        fail(place_of(source), "position " + std::to_string(i) + " is not finite");
      part.positions.push_back({at[0], at[1], at[2]});
    }
  }

  /// Returns the vertex indices among all indices of a primitive.
  std::vector<uint32_t> vertices_of(const XmlElement& primitive, const XmlElement* p, size_t vertices) const {
    uint64_t stride = 1, offset = 0;
    for_each_child(primitive, "input", [&](const XmlElement& input) {
      const uint64_t at = whole(input, "offset", 0);
      if (at > 255) fail(place_of(input), "offset is " + std::to_string(at) + "; the limit is 255");
      stride = std::max(stride, at + 1);
      if (input.value("semantic") == "VERTEX") offset = at;
    });
    std::vector<uint32_t> out;
    if (!p) return out;
    const std::vector<uint64_t> all = numbers<uint64_t>(*p);
    for (size_t i = offset; i < all.size(); i += stride) {
      if (all[i] >= vertices)
        fail(place_of(primitive),
             "vertex index " + std::to_string(all[i]) + " is out of range; " + vertices_there(vertices));
      out.push_back(static_cast<uint32_t>(all[i]));
    }
    return out;
  }

  void add_polylist(const XmlElement& polylist, RawMesh& part) {
    const std::vector<uint32_t> v = vertices_of(polylist, polylist.child("p"), part.positions.size());
    const XmlElement* const vcount = polylist.child("vcount");
    size_t at = 0;
    for (const uint64_t count : vcount ? numbers<uint64_t>(*vcount) : std::vector<uint64_t>()) {
      if (count > v.size() - at) fail(place_of(polylist), "is cut off: vcount has more corners than p");
      part.add_face(v.data() + at, count);
      at += count;
    }
  }

  void add_primitive(const XmlElement& element, RawMesh& part) {
    const std::string& name = element.name;
    if (name == "polylist") return add_polylist(element, part);
    if (name == "polygons" && element.child("ph")) fail(place_of(element), "polygons with holes are not read");
    for (const auto& known : {"triangles", "polygons", "tristrips", "trifans", "lines", "linestrips"})
      if (name == known)
        for_each_child(element, "p", [&](const XmlElement& p) {
          add_elements(element, vertices_of(element, &p, part.positions.size()), part);
        });
  }

  void add_elements(const XmlElement& element, const std::vector<uint32_t>& v, RawMesh& part) const {
    const std::string& name = element.name;
    if (name == "triangles" && v.size() % 3 != 0)
      fail(place_of(element), "has " + count_text(v.size(), "corner") + ", which is no multiple of 3");
    for (size_t i = 0; name == "triangles" && i < v.size(); i += 3) part.add_face({v[i], v[i + 1], v[i + 2]});
    if (name == "polygons") part.add_face(v.data(), v.size());
    if (name == "tristrips") part.add_strip(v);
    if (name == "trifans") part.add_fan(v);
    for (size_t i = 1; name == "lines" && i < v.size(); i += 2) part.edges.push_back({v[i - 1], v[i]});
    for (size_t i = 1; name == "linestrips" && i < v.size(); ++i) part.edges.push_back({v[i - 1], v[i]});
  }

  const std::string& file_;
  XmlTree document_;
  std::map<std::string, const XmlElement*, std::less<>> ids_;
  RawMesh mesh_;
  Expansion expansion_;
  MeshPlacer placer_;
  std::map<const XmlElement*, Node> nodes_;
  std::map<const XmlElement*, RawMesh> parts_;  ///< the geometries that were placed
  std::map<const XmlElement*, std::vector<double>> arrays_;
  std::map<const XmlElement*, const XmlElement*> geometries_;  ///< behind controllers
  std::set<std::string> notes_;
};

}  // namespace

RawMesh read_dae(std::string_view text, const std::string& file) { return DaeReader(text, file).run(); }

}  // namespace collided::scenes
