#pragma once
// XML as a tree of elements. It is parsed by expat, which is the parser of the Python package as well, so that both
// refuse the same files.

#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace collided::scenes {

struct XmlElement {
  std::string name;  ///< without the namespace
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string text;  ///< before the first child, without comments
  std::vector<const XmlElement*> children;

  /// Null if there is none.
  const std::string* attribute(std::string_view name) const;
  /// The value of an attribute; empty if there is none.
  std::string value(std::string_view name) const;
  /// The first child of this name; null if there is none.
  const XmlElement* child(std::string_view name) const;
};

/// The elements of a document; the root comes first.
using XmlTree = std::deque<XmlElement>;

/// Throws std::runtime_error naming the file, the line and the problem. Elements may be nested `max_depth` deep.
XmlTree parse_xml(std::string_view text, const std::string& file, size_t max_depth);

}  // namespace collided::scenes
