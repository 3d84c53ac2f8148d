// Connects a session to its scene, as often as it takes.

#include "client/cpp/session/connector.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <utility>

namespace collided::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kQuietTime(10'000), kAnswerTime(5'000);  // those of gRPC's keepalive

[[noreturn]] void refuse(const std::string& field, const std::string& why) {
  throw Error(grpc::INVALID_ARGUMENT, field + " " + why, field);
}

void check_time(const char* field, milliseconds time, milliseconds least) {
  if (time < least)
    refuse(field,
           "is " + std::to_string(time.count()) + " ms; it must be " + std::to_string(least.count()) + " ms or more");
}

const SessionOptions& checked(const SessionOptions& options) {
  check_time("options.give_up", options.give_up, milliseconds(0));
  check_time("options.first_pause", options.first_pause, milliseconds(0));
  check_time("options.longest_pause", options.longest_pause, options.first_pause);
  const StreamOptions& stream = options.stream;
  if (!stream.resume_token.empty()) refuse("options.stream.resume_token", "is set; a session makes its own scene");
  if (stream.delivery == v1::DELIVERY_POLICY_LATEST_WINS)
    refuse("options.stream.delivery", "is LATEST_WINS; a session answers every frame");
  if (!stream.local.cuda_ipc_handle.empty())
    refuse("options.stream.local.cuda_ipc_handle", "is set; a session copies its frames: use a stream");
  if (!stream.local.output_cuda_ipc_handle.empty())
    refuse("options.stream.local.output_cuda_ipc_handle", "is set; a session copies its contacts: use a stream");
  return options;
}

const v1::SceneSpec& checked(const v1::SceneSpec& spec) {
  if (spec.meshes_size() > 0)
    refuse("spec.meshes", "has " + std::to_string(spec.meshes_size()) + " meshes; they are an argument of their own");
  return spec;
}

/// A stream that waited too long for a frame has ended, and the scene's lease runs.
bool has_idled_out(const Error& error) {
  return error.code() == grpc::RESOURCE_EXHAUSTED && error.message().starts_with("max_idle_seconds ");
}

/// Ignores errors: it cleans up after one, which is the one to report, and the scene's lease ends it otherwise.
void try_delete(Client& client, const v1::Scene& scene) try {
  client.delete_scene(scene.scene_id());
} catch (const Error&) {
}

/// Proxies may not pass on why a stream was refused: a call is told.
bool is_gone(Client& client, const v1::Scene& scene) try {
  client.get_scene(scene.scene_id());
  return false;
} catch (const Error& e) {
  if (e.code() != grpc::NOT_FOUND) throw;
  return true;
}

}  // namespace

bool may_pass(const Error& error) {
  return is_connection_lost(error) || error.code() == grpc::NOT_FOUND || error.code() == grpc::DEADLINE_EXCEEDED ||
         error.retry_after_seconds() || has_idled_out(error);
}

Connector::Connector(ChannelFactory channels, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                     const SessionOptions& options)
    : channels_(std::move(channels)), options_(checked(options)), input_(checked(spec), meshes) {}

Connector::Opened Connector::create() const {
  Client client = Client::connect(channels_.with(channels_.options()));
  return create(client);
}

Connector::Opened Connector::create(Client& client) const {
  v1::Scene scene = client.create_scene(input_.spec(), input_.meshes(), options_.lease_seconds);
  try {
    FrameStream stream = client.stream(scene, options_.stream);
    return {std::move(scene), std::move(stream), true};
  } catch (const Error&) {
    try_delete(client, scene);
    throw;
  }
}

Connector::Opened Connector::reopen(const v1::Scene& scene, bool is_reusable, Time deadline) const {
  const auto left = std::chrono::duration_cast<milliseconds>(deadline - std::chrono::steady_clock::now());
  Client client = Client::connect(channels_.with(options_within(std::max(left, milliseconds(1)))));
  try {
    // Told at once if it is gone, where an endpoint that is gone would be waited for.
    if (is_reusable && !scene.endpoint().empty()) client.get_scene(scene.scene_id());
    if (is_reusable) return {scene, client.resume(scene, options_.stream), false};
    client.delete_scene(scene.scene_id());
  } catch (const Error& e) {
    const bool is_told = e.code() == grpc::NOT_FOUND;
    if (!is_told && !(is_reusable && is_connection_lost(e) && is_gone(client, scene))) throw;
  }
  return create(client);
}

std::optional<Connector::Opened> Connector::leave(const v1::Scene& scene) const try {
  Client client = Client::connect(channels_.with(channels_.options()));
  Opened opened = create(client);
  try_delete(client, scene);
  return opened;
} catch (const Error&) {
  return std::nullopt;
}

void Connector::remove(const v1::Scene& scene) const try {
  Client::connect(channels_.with(channels_.options())).delete_scene(scene.scene_id());
} catch (const Error& e) {
  if (e.code() != grpc::NOT_FOUND) throw;
}

FrameOutput Connector::receive(FrameStream& stream) const {
  const bool is_watched = stream.is_local() && !channels_.in_process();
  for (;;) {
    if (auto output = stream.receive_within(is_watched ? kQuietTime : milliseconds::max())) return std::move(*output);
    check_answers();
  }
}

/// Throws Error if the daemon does not answer a call. Whatever else comes of it, such as a refusal, is an answer.
void Connector::check_answers() const try {
  Client::connect(channels_.with(options_within(kAnswerTime)));
} catch (const Error& e) {
  if (is_connection_lost(e) || e.code() == grpc::DEADLINE_EXCEEDED) throw;
}

ConnectOptions Connector::options_within(milliseconds time) const {
  ConnectOptions options = channels_.options();
  options.patience = std::min(time, options.patience);
  options.deadline = std::min(time, options.deadline);
  return options;
}

void Connector::ask(FrameStream& stream, uint64_t id, std::span<const FrameUpdate> updates,
                    const FrameOptions& options) const {
  stream.send(id, updates, options);
  const auto limit = channels_.options().deadline;
  const auto output = stream.receive_within(limit);
  if (!output)
    throw Error(grpc::DEADLINE_EXCEEDED, "the daemon at " + channels_.address() +
                                             " did not put the scene where it was within " +
                                             std::to_string(limit.count()) + " ms (deadline)");
  output->check();
}

uint64_t Connector::restore(FrameStream& stream, const SceneMemory& memory) const {
  uint64_t id = stream.scene().last_frame_id();
  if (!memory.first()) return id;
  const bool is_new = id == 0;
  if (is_new) ask(stream, ++id, memory.first()->views(), memory.first()->options);
  const std::vector<FrameUpdate> updates = memory.updates(is_new);
  if (!updates.empty()) ask(stream, ++id, updates, memory.options());
  return id;
}

}  // namespace collided::client
