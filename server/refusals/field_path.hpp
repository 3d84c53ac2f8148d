#pragma once
// Maps fields of the engine's structs to the protocol's, which clients know. No gRPC here.

#include <cctype>
#include <string>
#include <string_view>
#include <utility>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {

/// The path with its last part renamed, if that is `from`.
inline std::string with_last_part(const std::string& path, std::string_view from, std::string_view to) {
  const bool whole = path == from;
  const bool last = path.size() > from.size() && path.ends_with(from) && path[path.size() - from.size() - 1] == '.';
  return whole || last ? path.substr(0, path.size() - from.size()) + std::string(to) : path;
}

/// The text with fields of the engine's own under the names that clients set.
inline std::string with_protocol_names(std::string text) {
  const auto is_of_word = [](char c) { return c == '_' || (std::isalnum(static_cast<unsigned char>(c)) != 0); };
  for (const auto& [engine, protocol] :
       {std::pair<std::string_view, std::string_view>{"start_transform", "rigid.start_matrix"},
        {"start_fraction", "from_last_fraction"},
        {"quantized_in", "quantization_box"},
        {"excluded_rings", "exclude_rings"},
        {"excludes_rest_pairs", "exclude_rest_pairs"}})
    for (size_t at = text.find(engine); at != std::string::npos; at = text.find(engine, at + protocol.size())) {
      const size_t end = at + engine.size();
      const bool is_word = (at == 0 || !is_of_word(text[at - 1])) && (end == text.size() || !is_of_word(text[end]));
      if (is_word) text.replace(at, engine.size(), protocol);
    }
  return text;
}

/// "meshes[0].triangles[5]" -> "spec.meshes[0].triangles[5]".
inline std::string spec_path(const std::string& engine_path) {
  if (engine_path.empty()) return "spec";
  std::string path = with_last_part(with_protocol_names(engine_path), "memory_budget", "memory_budget_bytes");
  for (const auto& [engine, protocol] : {std::pair{"scalar", "position_format"}, {"engine", "broad_phase_engine"}})
    path = with_last_part(path, engine, protocol);
  return "spec." + path;
}

/// "updates[1].end" -> "frame.updates[1].positions". What first positions show of a mesh is refused by the scene's
/// field: "meshes[1].solid" -> "spec.meshes[1].solid".
inline std::string frame_path(const std::string& engine_path) {
  if (engine_path.empty()) return "frame";
  if (engine_path.starts_with("meshes[")) return spec_path(engine_path);
  std::string path = with_protocol_names(engine_path);
  for (const auto& [engine, protocol] : {std::pair{"indices", "sparse.indices"},
                                         {"start", "start_positions"},
                                         {"end", "positions"},
                                         {"transform", "rigid.matrix"}})
    path = with_last_part(path, engine, protocol);
  for (const auto& [engine, protocol] :
       {std::pair{"edit.excluded[", "edit.exclude_meshes["}, {"edit.included[", "edit.include_meshes["}})
    if (path.starts_with(engine)) path = protocol + path.substr(std::string_view(engine).size());
  return "frame." + path;
}

/// The engine's message, with `name` in place of the engine's field.
inline std::string renamed(const InvalidInput& error, const std::string& name) {
  const std::string message = error.what();
  const auto at = error.field().empty() ? std::string::npos : message.find(error.field());
  if (at == std::string::npos) return name + ": " + with_protocol_names(message);
  return with_protocol_names(message.substr(0, at)) + name +
         with_protocol_names(message.substr(at + error.field().size()));
}

/// The engine's refusal, naming the protocol's path.
inline InvalidInput with_path(const InvalidInput& error, std::string (*path)(const std::string&)) {
  const std::string field = path(error.field());
  return {field, renamed(error, field)};
}

/// Throws a refusal that names the budget's path if the engine refused because of the scene's budget.
inline void throw_if_budget(const ResourceExhausted& error) {
  constexpr std::string_view kEngine = "memory_budget";
  const std::string field = "spec.memory_budget_bytes", message = error.what();
  if (message.starts_with(kEngine)) throw LimitExceeded(field, field + message.substr(kEngine.size()));
}

/// What `call` returns; what the engine refuses names the protocol's path, and the scene's budget by its own.
template <class Call>
auto naming_paths(std::string (*path)(const std::string&), const Call& call) try {
  return call();
} catch (const InvalidInput& e) {
  throw with_path(e, path);
} catch (const ResourceExhausted& e) {
  throw_if_budget(e);
  throw;
}

}  // namespace collided::server
