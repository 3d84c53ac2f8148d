#pragma once
// A glTF 2.0 document: its JSON, and the numbers that its accessors describe.

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/scenes/mesh_files/expansion.hpp"
#include "client/scenes/scene.hpp"

namespace collided::scenes {

using Json = nlohmann::json;

class GltfDocument {
 public:
  /// `text`: JSON, or a GLB container. Outlives the document. Throws std::runtime_error as all readers do.
  GltfDocument(std::string_view text, std::string file, Expansion& expansion);

  const Json& root() const { return root_; }
  /// How many elements the root's array of this name has.
  size_t size(const char* array) const;
  /// The element of the root's array, such as mesh 3 of "meshes".
  const Json& element(const char* array, uint64_t index) const;
  /// An element's member that must be a whole number; `otherwise` stands for one that is missing.
  uint64_t whole(const Json& object, const char* key, const std::string& place,
                 std::optional<uint64_t> otherwise = {}) const;
  /// An element's member that must be an array; an empty one if it is missing.
  const Json& list(const Json& object, const char* key, const std::string& place) const;

  std::vector<Vec3d> positions(uint64_t accessor);
  /// `corners_each`: the corners that one index can make, which are counted.
  std::vector<uint32_t> indices(uint64_t accessor, uint64_t corners_each);
  std::string place(const std::string& what, uint64_t index) const;

 private:
  std::string_view buffer(uint64_t index);
  std::string_view view(uint64_t index);
  /// The numbers of an accessor whose elements have so many components. Each element counts as `counts_as`.
  std::vector<double> numbers(uint64_t accessor, const std::string& type, size_t components, uint64_t counts_as);
  void add_sparse(const Json& accessor, size_t components, std::vector<double>& numbers, const std::string& place);
  const std::string& load(const Json& buffer, uint64_t index, const std::string& place);
  void parse(std::string_view json);
  std::string_view open_container(std::string_view text);

  std::string file_;
  Expansion& expansion_;
  Json root_;
  std::string_view binary_;  ///< of a GLB container
  bool has_binary_ = false;
  std::map<std::string, std::string> buffers_;  ///< by the path of their file, or their number
};

}  // namespace collided::scenes
