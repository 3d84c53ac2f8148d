#pragma once
// The engine names fields by its own structs; clients know those of the protocol.

#include <string>
#include <string_view>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {

// A path with its last part renamed, if that is `from`.
inline std::string with_last_part(const std::string& path, std::string_view from, std::string_view to) {
  const bool whole = path == from;
  const bool last = path.size() > from.size() && path.ends_with(from) && path[path.size() - from.size() - 1] == '.';
  return whole || last ? path.substr(0, path.size() - from.size()) + std::string(to) : path;
}

/// "updates[1].end" -> "frame.updates[1].positions".
inline std::string frame_path(const std::string& engine_path) {
  if (engine_path.empty()) return "frame";
  const std::string indices = with_last_part(engine_path, "indices", "sparse.indices");
  const std::string path = with_last_part(indices, "start", "start_positions");
  return "frame." + with_last_part(path, "end", "positions");
}

/// "meshes[0].triangles[5]" -> "spec.meshes[0].triangles[5]".
inline std::string spec_path(const std::string& engine_path) {
  if (engine_path.empty()) return "spec";
  const std::string path = with_last_part(engine_path, "memory_budget", "memory_budget_bytes");
  return "spec." + with_last_part(path, "scalar", "position_format");
}

/// The engine's refusal with the path that the client knows, in its message, too.
inline InvalidInput with_path(const InvalidInput& error, std::string (*path)(const std::string&)) {
  const std::string ours = path(error.field()), message = error.what();
  const auto at = error.field().empty() ? std::string::npos : message.find(error.field());
  if (at == std::string::npos) return {ours, ours + ": " + message};
  return {ours, message.substr(0, at) + ours + message.substr(at + error.field().size())};
}

/// Throws the engine's refusal with the path of the budget, if it is about that.
inline void throw_if_budget(const ResourceExhausted& error) {
  constexpr std::string_view kEngine = "memory_budget";
  const std::string field = "spec.memory_budget_bytes", message = error.what();
  if (message.starts_with(kEngine)) throw LimitExceeded(field, field + message.substr(kEngine.size()));
}

}  // namespace collided::server
