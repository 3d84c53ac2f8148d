#include "server/sets/world_errors.hpp"

#include <grpcpp/support/status.h>

namespace collided::server {
namespace {

// "updates[5].end" of the engine -> "frame.updates[0].positions".
std::string field_of(const std::string& engine, const SetFramePaths& paths) {
  const std::string last = engine.substr(engine.rfind('.') + 1);
  if (last == "end" || last == "updates") return paths.positions + ".positions";
  if (last == "start") return paths.positions + ".start_positions";
  return paths.frame + "." + (last == "mesh" ? "meshes" : last);
}

// The engine's sentence begins with its field.
std::string sentence_of(const RefusedWorld& refused, const std::string& field) {
  const bool begins_so = refused.what.starts_with(refused.field);
  return field + (begins_so ? refused.what.substr(refused.field.size()) : ": " + refused.what);
}

}  // namespace

void fill_world_error(const RefusedWorld& refused, size_t index, const SetFramePaths& paths, pb::WorldError* out) {
  out->set_world(refused.world);
  out->mutable_error()->set_code(grpc::INVALID_ARGUMENT);
  if (index >= kMaxWorldMessages) return;
  const std::string field = field_of(refused.field, paths);
  out->mutable_error()->set_field(field);
  out->mutable_error()->set_message(sentence_of(refused, field));
}

}  // namespace collided::server
