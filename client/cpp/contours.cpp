// The lines along which meshes cross, joined from edge-triangle contacts.

#include "client/cpp/contours.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

namespace collided::client {

namespace {

constexpr int kInvalidArgument = 3, kDataLoss = 15;

/// An end of the segment in which two triangles cross.
struct SegmentEnd {
  std::array<uint32_t, 2> triangles;  ///< the lower id first
  uint32_t crossing;
};

std::array<uint32_t, 2> sorted(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

std::optional<uint32_t> common_corner(const SceneFeatures::Element& a, const SceneFeatures::Element& b) {
  for (const uint32_t vertex : a)
    if (std::ranges::count(b, vertex) > 0) return vertex;
  return std::nullopt;
}

/// Crossings and common corners, and the segments between them. A corner is a node for each segment that ends there,
/// numbered from the number of crossings on.
class SegmentGraph {
 public:
  SegmentGraph(const Contacts& crossings, const SceneFeatures& scene) : crossing_count_(crossings.count) {
    std::vector<SegmentEnd> ends = ends_of(crossings, scene);
    std::ranges::sort(ends, {}, [](const SegmentEnd& end) { return std::pair(end.triangles, end.crossing); });
    for (size_t i = 0, next; i < ends.size(); i = next) {
      for (next = i; next < ends.size() && ends[next].triangles == ends[i].triangles;) ++next;
      add_segment(std::span(ends).subspan(i, next - i), scene);
    }
    number_links();
  }

  size_t crossing_count() const { return crossing_count_; }
  size_t segment_count() const { return segments_.size(); }
  /// The segments that end at a node.
  std::span<const uint32_t> links(size_t node) const {
    return std::span(links_).subspan(first_link_[node], first_link_[node + 1] - first_link_[node]);
  }
  uint32_t other_end(uint32_t segment, uint32_t node) const {
    const auto& [a, b] = segments_[segment];
    return a == node ? b : a;
  }
  /// Contours go on over nodes of two segments, and end at others.
  bool is_end(size_t node) const { return links(node).size() != 2; }
  /// The vertex of a node that is no crossing.
  uint32_t corner(uint32_t node) const { return corners_[node - crossing_count_]; }

 private:
  static std::vector<SegmentEnd> ends_of(const Contacts& crossings, const SceneFeatures& scene) {
    std::vector<SegmentEnd> ends;
    for (uint32_t i = 0; i < crossings.count; ++i) {
      const auto [edge, triangle] = crossings.elements[i];
      for (const uint32_t own : scene.triangles_of(edge)) ends.push_back({sorted(own, triangle), i});
    }
    return ends;
  }

  /// `ends` are those of one pair of triangles.
  void add_segment(std::span<const SegmentEnd> ends, const SceneFeatures& scene) {
    const auto [a, b] = ends[0].triangles;
    const std::optional<uint32_t> corner = common_corner(scene.element(a), scene.element(b));
    if (ends.size() + corner.has_value() > 2)
      throw Error(kDataLoss, "the daemon's contacts have " + std::to_string(ends.size()) +
                                 " crossings between the triangles " + std::to_string(a) + " and " + std::to_string(b) +
                                 (corner ? ", which share a corner" : "") + "; it must be at most " +
                                 (corner ? "1" : "2"));
    if (corner) {
      segments_.push_back({ends[0].crossing, static_cast<uint32_t>(crossing_count_ + corners_.size())});
      corners_.push_back(*corner);
    } else if (ends.size() == 2) {
      segments_.push_back({ends[0].crossing, ends[1].crossing});
    }
  }

  void number_links() {
    first_link_.assign(crossing_count_ + corners_.size() + 1, 0);
    for (const auto& segment : segments_)
      for (const uint32_t node : segment) ++first_link_[node + 1];
    std::partial_sum(first_link_.begin(), first_link_.end(), first_link_.begin());
    links_.resize(2 * segments_.size());
    std::vector<size_t> next(first_link_.begin(), first_link_.end() - 1);
    for (uint32_t id = 0; id < segments_.size(); ++id)
      for (const uint32_t node : segments_[id]) links_[next[node]++] = id;
  }

  size_t crossing_count_;
  std::vector<std::array<uint32_t, 2>> segments_;  ///< nodes
  std::vector<uint32_t> corners_;                  ///< vertices
  std::vector<size_t> first_link_;                 ///< of each node, in links_; one more entry at the end
  std::vector<uint32_t> links_;                    ///< segments, node after node
};

/// Divides a graph of segments into chains of nodes.
class Chains {
 public:
  explicit Chains(const SegmentGraph& graph) : graph_(graph), used_(graph.segment_count()) {
    for (uint32_t node = 0; node < graph.crossing_count(); ++node)
      if (graph.is_end(node)) add_from(node);
    // Both ends of a chain that is left may be corners, whose nodes follow those of crossings. Then circles are left.
    for (uint32_t node = 0; node < graph.crossing_count(); ++node) add_through(node);
  }

  /// The nodes of each chain; a circle ends with its first node.
  std::vector<std::vector<uint32_t>> take() { return std::move(chains_); }

 private:
  /// Adds the chains that begin at an end, or the node alone if no segment ends there.
  void add_from(uint32_t node) {
    if (graph_.links(node).empty()) chains_.push_back({node});
    for (const uint32_t segment : graph_.links(node))
      if (!used_[segment]) chains_.push_back(walk(node, segment));
  }

  /// Adds the chain that goes through a node, unless it is there already.
  void add_through(uint32_t node) {
    const auto links = graph_.links(node);
    if (links.size() != 2 || used_[links[0]] || used_[links[1]]) return;
    std::vector<uint32_t> chain = walk(node, links[0]);
    if (chain.back() != node) {
      const std::vector<uint32_t> rest = walk(node, links[1]);
      std::ranges::reverse(chain);
      chain.insert(chain.end(), rest.begin() + 1, rest.end());
    }
    chains_.push_back(std::move(chain));
  }

  /// Goes from a node along a segment up to an end, or to where it began.
  std::vector<uint32_t> walk(uint32_t node, uint32_t segment) {
    std::vector<uint32_t> chain{node};
    for (;;) {
      used_[segment] = true;
      chain.push_back(graph_.other_end(segment, chain.back()));
      if (chain.back() == node || graph_.is_end(chain.back())) return chain;
      const auto links = graph_.links(chain.back());
      segment = links[links[0] == segment ? 1 : 0];
    }
  }

  const SegmentGraph& graph_;
  std::vector<bool> used_;
  std::vector<std::vector<uint32_t>> chains_;
};

void check_arguments(const Contacts& crossings, const SceneFeatures& scene, Positions positions) {
  if (crossings.elements.size() != crossings.count || crossings.weights.size() != crossings.count)
    throw Error(kInvalidArgument, "crossings have " + std::to_string(crossings.elements.size()) + " elements and " +
                                      std::to_string(crossings.weights.size()) + " weights; contours need " +
                                      std::to_string(crossings.count) + " of each");
  if (positions.size() != scene.vertex_count())
    throw Error(kInvalidArgument, "positions are of " + std::to_string(positions.size()) + " vertices; the scene has " +
                                      std::to_string(scene.vertex_count()));
}

}  // namespace

std::array<double, 3> crossing_point(const Contacts& crossings, size_t i, const SceneFeatures& scene,
                                     Positions positions) {
  const auto& [a, b, c] = scene.element(crossings.elements[i][1]);
  const auto& [w0, w1] = crossings.weights[i];
  std::array<double, 3> point;
  for (size_t axis = 0; axis < 3; ++axis)
    point[axis] = (1 - w0 - w1) * positions[a][axis] + w0 * positions[b][axis] + w1 * positions[c][axis];
  return point;
}

std::vector<Contour> join_crossings(const Contacts& crossings, const SceneFeatures& scene, Positions positions) {
  check_arguments(crossings, scene, positions);
  const SegmentGraph graph(crossings, scene);
  const auto point_of = [&](uint32_t node) {
    return node < crossings.count ? Contour::Point{crossing_point(crossings, node, scene, positions), node}
                                  : Contour::Point{positions[graph.corner(node)], kNoCrossing};
  };
  std::vector<Contour> contours;
  for (std::vector<uint32_t>& chain : Chains(graph).take()) {
    Contour& contour = contours.emplace_back();
    contour.is_closed = chain.size() > 1 && chain.front() == chain.back();
    if (contour.is_closed) chain.pop_back();
    for (const uint32_t node : chain) contour.points.push_back(point_of(node));
    const auto [edge, triangle] = crossings.elements[*std::ranges::min_element(chain)];
    contour.meshes =
        sorted(static_cast<uint32_t>(scene.mesh_of_edge(edge)), static_cast<uint32_t>(scene.mesh_of_element(triangle)));
  }
  const auto first_crossing = [](const Contour& contour) {
    return std::ranges::min_element(contour.points, {}, &Contour::Point::crossing)->crossing;
  };
  std::ranges::stable_sort(contours, {}, first_crossing);
  return contours;
}

}  // namespace collided::client
