// A glTF 2.0 document: its JSON, and the numbers that its accessors describe.

#include "client/scenes/mesh_files/gltf_document.hpp"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <utility>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

namespace {

/// Zeros that an accessor without data stands for take no bytes in the file, so their number is limited.
constexpr uint64_t kMaxImplicitElements = 1'000'000;

uint32_t little_endian(std::string_view bytes) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value |= uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return value;
}

std::string decode_base64(std::string_view text, const std::string& place) {
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1) fail(place, "its data is not base64");
  std::string out;
  uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const size_t value = kAlphabet.find(c);
    if (value == std::string_view::npos) fail(place, "its data is not base64");
    bits = bits << 6 | static_cast<uint32_t>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    out += static_cast<char>(bits >> held & 0xFF);
  }
  return out;
}

std::string decode_percent(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(&text[i + 1], &text[i + 3], value, 16).ptr == &text[i + 3]) {
      out += static_cast<char>(value);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

size_t size_of_component(uint64_t type, const std::string& place) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      fail(place, "componentType " + std::to_string(type) + " is none of glTF's");
  }
}

double component(const char* bytes, uint64_t type) {
  const auto byte = [&](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(bytes[i])); };
  switch (type) {
    case 5120:
      return static_cast<int8_t>(byte(0));
    case 5121:
      return byte(0);
    case 5122:
      return static_cast<int16_t>(byte(0) | byte(1) << 8);
    case 5123:
      return byte(0) | byte(1) << 8;
    default:
      break;
  }
  const uint32_t word = byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
  return type == 5125 ? static_cast<double>(word) : static_cast<double>(std::bit_cast<float>(word));
}

/// Returns the fraction that a normalised integer stands for.
double normalised(double value, uint64_t type) {
  switch (type) {
    case 5120:
      return std::max(value / 127, -1.0);
    case 5121:
      return value / 255;
    case 5122:
      return std::max(value / 32767, -1.0);
    case 5123:
      return value / 65535;
    default:
      return value;
  }
}

/// Numbers of `count` elements in the bytes from `offset` on; `stride` 0: one after the other. Calls fits() once the
/// elements are known to be in the bytes.
template <class Fits>
void unpack(std::string_view bytes, uint64_t offset, uint64_t stride, uint64_t count, size_t components, uint64_t type,
            std::vector<double>& out, const std::string& place, const Fits& fits) {
  const size_t each = size_of_component(type, place), element = each * components;
  if (stride == 0) stride = element;
  if (stride < element) fail(place, "byteStride " + std::to_string(stride) + " is less than an element");
  const uint64_t left = offset < bytes.size() ? bytes.size() - offset : 0;
  if (count > 0 && (left < element || (count - 1) > (left - element) / stride))
    fail(place, "is cut off: " + count_text(count, "element") + " do not fit in " + count_text(left, "byte"));
  fits();
  for (uint64_t i = 0; i < count; ++i)
    for (size_t k = 0; k < components; ++k)
      out.push_back(component(bytes.data() + offset + i * stride + k * each, type));
}

}  // namespace

GltfDocument::GltfDocument(std::string_view text, std::string file, Expansion& expansion)
    : file_(std::move(file)), expansion_(expansion) {
  parse(text.starts_with("glTF") ? open_container(text) : text);
}

std::string GltfDocument::place(const std::string& what, uint64_t index) const {
  return file_ + ": " + what + " " + std::to_string(index);
}

std::string_view GltfDocument::open_container(std::string_view text) {
  constexpr uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
  if (text.size() < 20) fail(file_, "is cut off in its header");
  if (const uint32_t version = little_endian(text.substr(4)); version != 2)
    fail(file_, "is GLB of version " + std::to_string(version) + "; version 2 is read");
  if (const uint32_t length = little_endian(text.substr(8)); length > text.size())
    fail(file_, "is cut off: it has " + std::to_string(text.size()) + " of " + std::to_string(length) + " bytes");
  text.remove_prefix(12);
  std::string_view json;
  while (text.size() >= 8) {
    const uint32_t length = little_endian(text), type = little_endian(text.substr(4));
    if (length > text.size() - 8) fail(file_, "is cut off within a chunk of " + count_text(length, "byte"));
    const std::string_view chunk = text.substr(8, length);
    if (type == kJson && json.empty()) json = chunk;
    if (type == kBinary && !has_binary_) binary_ = chunk, has_binary_ = true;
    text.remove_prefix(8 + std::min<size_t>(length + (4 - length % 4) % 4, text.size() - 8));
  }
  if (json.empty()) fail(file_, "has no JSON chunk");
  return json;
}

void GltfDocument::parse(std::string_view json) {
  json = without_mark(json);
  while (json.ends_with('\0')) json.remove_suffix(1);  // some exporters pad with it
  // The parser takes a byte of 0 for the end.
  if (json.find('\0') == std::string_view::npos) root_ = Json::parse(json, nullptr, false);
  if (!root_.is_object()) fail(file_, "is not a JSON object, or is cut off");
  const Json& asset = root_.contains("asset") ? root_["asset"] : root_;
  const std::string version = asset.is_object() && asset.contains("version") && asset["version"].is_string()
                                  ? asset["version"].get<std::string>()
                                  : "";
  if (!version.starts_with("2.")) fail(file_, "is glTF of version " + in_quotes(version) + "; version 2 is read");
  // What else a file requires may change where the triangles are.
  constexpr std::array<std::string_view, 5> kHarmless{"KHR_mesh_quantization", "KHR_materials_", "KHR_texture_",
                                                      "EXT_texture_", "KHR_lights_"};
  for (const Json& required : list(root_, "extensionsRequired", file_)) {
    const std::string name = required.is_string() ? required.get<std::string>() : "";
    if (std::none_of(kHarmless.begin(), kHarmless.end(),
                     [&](std::string_view known) { return name.starts_with(known); }))
      fail(file_, "requires the extension '" + name.substr(0, 80) + "', which is not read");
  }
}

size_t GltfDocument::size(const char* array) const { return list(root_, array, file_).size(); }

const Json& GltfDocument::element(const char* array, uint64_t index) const {
  const Json& elements = list(root_, array, file_);
  if (index >= elements.size())
    fail(file_, std::string(array) + " has no element " + std::to_string(index) + "; there are " +
                    std::to_string(elements.size()));
  if (!elements[index].is_object()) fail(place(array, index), "must be an object");
  return elements[index];
}

uint64_t GltfDocument::whole(const Json& object, const char* key, const std::string& place,
                             std::optional<uint64_t> otherwise) const {
  const auto found = object.find(key);
  if (found == object.end() && otherwise) return *otherwise;
  const bool is_whole = found != object.end() && found->is_number_integer();
  if (!is_whole || (!found->is_number_unsigned() && found->get<int64_t>() != 0))  // -0 is signed
    fail(place, std::string(key) + " must be a whole number");
  return found->get<uint64_t>();
}

const Json& GltfDocument::list(const Json& object, const char* key, const std::string& place) const {
  static const Json kNone = Json::array();
  const auto found = object.find(key);
  if (found == object.end()) return kNone;
  if (!found->is_array()) fail(place, std::string(key) + " must be an array");
  return *found;
}

const std::string& GltfDocument::load(const Json& buffer, uint64_t index, const std::string& place) {
  const auto found = buffer.find("uri");
  if (found == buffer.end() || !found->is_string()) fail(place, "has no data");
  const std::string uri = found->get<std::string>();
  if (uri.starts_with("data:")) {
    const auto [at_index, is_new] = buffers_.try_emplace(std::to_string(index));
    if (!is_new) return at_index->second;
    constexpr std::string_view kMark = ";base64,";
    const size_t at = uri.find(kMark);
    if (at == std::string::npos) fail(place, "its data is not base64");
    return at_index->second = decode_base64(std::string_view(uri).substr(at + kMark.size()), place);
  }
  // A file from a stranger must not make the reader open files elsewhere.
  const std::filesystem::path name = decode_percent(uri);
  if (uri.find("://") != std::string::npos || name.is_absolute() ||
      std::find(name.begin(), name.end(), "..") != name.end())
    fail(place, "uri '" + uri.substr(0, 80) + "' is not in the folder of the file");
  // Buffers can name one file many times.
  const std::filesystem::path path = (std::filesystem::path(file_).parent_path() / name).lexically_normal();
  const auto [at, is_new] = buffers_.try_emplace("file " + path.string());
  if (!is_new) return at->second;
  try {
    at->second = read_file(path);
    expansion_.add_bytes(at->second.size());
    return at->second;
  } catch (const std::runtime_error& e) {
    fail(place, e.what());
  }
}

std::string_view GltfDocument::buffer(uint64_t index) {
  const Json& spec = element("buffers", index);
  const std::string at = place("buffer", index);
  const uint64_t length = whole(spec, "byteLength", at);
  std::string_view bytes;
  if (index == 0 && has_binary_ && !spec.contains("uri")) {
    bytes = binary_;
  } else {
    bytes = load(spec, index, at);
  }
  if (bytes.size() < length)
    fail(at, "is cut off: it has " + std::to_string(bytes.size()) + " of " + std::to_string(length) + " bytes");
  return bytes.substr(0, length);
}

std::string_view GltfDocument::view(uint64_t index) {
  const Json& spec = element("bufferViews", index);
  const std::string at = place("bufferView", index);
  const std::string_view bytes = buffer(whole(spec, "buffer", at));
  const uint64_t offset = whole(spec, "byteOffset", at, 0), length = whole(spec, "byteLength", at);
  if (offset > bytes.size() || length > bytes.size() - offset)
    fail(at, "is cut off: " + count_text(length, "byte") + " from " + std::to_string(offset) +
                 " on do not fit in a buffer of " + std::to_string(bytes.size()));
  return bytes.substr(offset, length);
}

std::vector<double> GltfDocument::numbers(uint64_t accessor, const std::string& type, size_t components,
                                          uint64_t counts_as) {
  const Json& spec = element("accessors", accessor);
  const std::string at = place("accessor", accessor);
  if (!spec.contains("type") || spec["type"] != type) fail(at, "type must be " + type);
  const uint64_t count = whole(spec, "count", at), component_type = whole(spec, "componentType", at);
  std::vector<double> out;
  if (spec.contains("bufferView")) {
    const uint64_t index = whole(spec, "bufferView", at);
    const uint64_t stride = whole(element("bufferViews", index), "byteStride", at, 0);
    unpack(view(index), whole(spec, "byteOffset", at, 0), stride, count, components, component_type, out, at,
           [&] { expansion_.count(counts_as * count); });
  } else {
    if (count > kMaxImplicitElements)
      fail(at, "has " + std::to_string(count) + " elements without data; the limit is " +
                   std::to_string(kMaxImplicitElements));
    size_of_component(component_type, at);
    expansion_.count(counts_as * count);
    out.resize(count * components);
  }
  if (spec.contains("sparse")) add_sparse(spec, components, out, at);
  if (spec.contains("normalized") && spec["normalized"] == true)
    for (double& x : out) x = normalised(x, component_type);
  return out;
}

void GltfDocument::add_sparse(const Json& accessor, size_t components, std::vector<double>& numbers,
                              const std::string& place) {
  const Json& sparse = accessor["sparse"];
  if (!sparse.is_object() || !sparse.contains("indices") || !sparse.contains("values") ||
      !sparse["indices"].is_object() || !sparse["values"].is_object())
    fail(place, "sparse must have indices and values");
  const Json &where = sparse["indices"], &what = sparse["values"];
  const uint64_t count = whole(sparse, "count", place), elements = numbers.size() / components;
  if (count > elements)
    fail(place, "sparse has " + count_text(count, "element") + "; the accessor has " + std::to_string(elements));
  const auto fits = [] {};  // they replace elements that were counted
  std::vector<double> indices, values;
  unpack(view(whole(where, "bufferView", place)), whole(where, "byteOffset", place, 0), 0, count, 1,
         whole(where, "componentType", place), indices, place + ": sparse indices", fits);
  unpack(view(whole(what, "bufferView", place)), whole(what, "byteOffset", place, 0), 0, count, components,
         whole(accessor, "componentType", place), values, place + ": sparse values", fits);
  for (uint64_t i = 0; i < count; ++i) {
    if (!(indices[i] >= 0 && indices[i] < static_cast<double>(elements)))
      fail(place, "a sparse index is out of range; there are " + count_text(elements, "element"));
    std::copy_n(&values[i * components], components, &numbers[static_cast<size_t>(indices[i]) * components]);
  }
}

std::vector<Vec3d> GltfDocument::positions(uint64_t accessor) {
  const std::vector<double> flat = numbers(accessor, "VEC3", 3, 1);
  std::vector<Vec3d> out;
  for (size_t i = 0; i < flat.size(); i += 3) {
    out.push_back({flat[i], flat[i + 1], flat[i + 2]});
    if (!std::isfinite(flat[i] + flat[i + 1] + flat[i + 2]))
      fail(place("accessor", accessor), "position " + std::to_string(i / 3) + " is not finite");
  }
  return out;
}

std::vector<uint32_t> GltfDocument::indices(uint64_t accessor, uint64_t corners_each) {
  const Json& spec = element("accessors", accessor);
  const uint64_t type = whole(spec, "componentType", place("accessor", accessor));
  if (type != 5121 && type != 5123 && type != 5125)
    fail(place("accessor", accessor), "componentType of indices must be 5121, 5123 or 5125");
  std::vector<uint32_t> out;
  for (const double index : numbers(accessor, "SCALAR", 1, corners_each)) out.push_back(static_cast<uint32_t>(index));
  return out;
}

}  // namespace collided::scenes
