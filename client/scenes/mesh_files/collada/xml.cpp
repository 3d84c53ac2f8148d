// XML as a tree of elements, parsed by expat.

#include "client/scenes/mesh_files/collada/xml.hpp"

#include <expat.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

constexpr char kNamespaceEnd = '}';

struct Builder {
  XmlTree tree;
  std::vector<XmlElement*> open;
  XML_Parser parser = nullptr;
  size_t max_depth = 0;
  bool is_too_deep = false, is_out_of_memory = false;
};

/// Runs `work`; an exception must not pass through expat, which is C.
template <class Work>
void guarded(Builder& builder, const Work& work) {
  try {
    work();
  } catch (const std::bad_alloc&) {
    builder.is_out_of_memory = true;
    XML_StopParser(builder.parser, XML_FALSE);
  }
}

void begin_element(void* data, const XML_Char* name, const XML_Char** attributes) {
  Builder& builder = *static_cast<Builder*>(data);
  guarded(builder, [&] {
    if (builder.open.size() > builder.max_depth) {
      builder.is_too_deep = true;
      XML_StopParser(builder.parser, XML_FALSE);
      return;
    }
    XmlElement& element = builder.tree.emplace_back();
    const std::string_view full = name;
    element.name = full.substr(full.rfind(kNamespaceEnd) + 1);
    for (; *attributes; attributes += 2) element.attributes.emplace_back(attributes[0], attributes[1]);
    if (!builder.open.empty()) builder.open.back()->children.push_back(&element);
    builder.open.push_back(&element);
  });
}

void end_element(void* data, const XML_Char*) {
  Builder& builder = *static_cast<Builder*>(data);
  if (!builder.open.empty()) builder.open.pop_back();
}

void add_text(void* data, const XML_Char* text, int length) {
  Builder& builder = *static_cast<Builder*>(data);
  guarded(builder, [&] {
    if (!builder.open.empty() && builder.open.back()->children.empty())
      builder.open.back()->text.append(text, static_cast<size_t>(length));
  });
}

/// True if the document declares an encoding other than UTF-8. It is then read as Latin-1, byte by byte: only names can
/// have characters beyond ASCII, and they are compared with each other alone.
bool has_other_encoding(std::string_view text) {
  if (!text.starts_with("<?xml")) return false;
  text = text.substr(0, text.find("?>"));
  text.remove_prefix(std::min(text.find("encoding"), text.size()));
  text.remove_prefix(std::min(text.find_first_of("\"'"), text.size()));
  if (text.empty()) return false;
  std::string name(text.substr(1, text.find(text.front(), 1) - 1));
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name != "utf-8";
}

// Expat 2.9 deprecates the name that older releases know.
uint64_t line_of(XML_Parser parser) {
#if XML_MAJOR_VERSION > 2 || XML_MINOR_VERSION >= 9
  return XML_GetCurrentLineNumber64(parser);
#else
  return XML_GetCurrentLineNumber(parser);
#endif
}

}  // namespace

const std::string* XmlElement::attribute(std::string_view wanted) const {
  for (const auto& [key, value] : attributes)
    if (key == wanted) return &value;
  return nullptr;
}

std::string XmlElement::value(std::string_view wanted) const {
  const std::string* const found = attribute(wanted);
  return found ? *found : std::string();
}

const XmlElement* XmlElement::child(std::string_view wanted) const {
  for (const XmlElement* one : children)
    if (one->name == wanted) return one;
  return nullptr;
}

XmlTree parse_xml(std::string_view text, const std::string& file, size_t max_depth) {
  if (text.find('\0') != std::string_view::npos) fail(file, "has bytes of 0; XML must be in UTF-8");
  const char* const encoding = has_other_encoding(text) ? "ISO-8859-1" : nullptr;
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(
      XML_ParserCreateNS(encoding, kNamespaceEnd), &XML_ParserFree);
  if (!parser) throw std::bad_alloc();
  Builder builder{.tree = {}, .open = {}, .parser = parser.get(), .max_depth = max_depth};
  XML_SetUserData(parser.get(), &builder);
  XML_SetElementHandler(parser.get(), begin_element, end_element);
  XML_SetCharacterDataHandler(parser.get(), add_text);
  constexpr size_t kMaxPiece = size_t{1} << 30;  // expat counts in int
  XML_Status status = XML_STATUS_OK;
  do {
    const std::string_view piece = text.substr(0, kMaxPiece);
    text.remove_prefix(piece.size());
    status = XML_Parse(parser.get(), piece.data(), static_cast<int>(piece.size()), text.empty());
  } while (status == XML_STATUS_OK && !text.empty());
  if (builder.is_out_of_memory || XML_GetErrorCode(parser.get()) == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
  if (builder.is_too_deep) fail(file, "elements are nested deeper than " + std::to_string(max_depth));
  if (status != XML_STATUS_OK)
    fail(file + ":" + std::to_string(line_of(parser.get())), "is not well-formed XML, or is cut off");
  return std::move(builder.tree);
}

}  // namespace collided::scenes
