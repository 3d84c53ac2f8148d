// Options that bound what clients may ask for.
#include "server/config/accuracy_names.hpp"
#include "server/config/options.hpp"

namespace collided::server {
namespace {

struct Range {
  uint64_t min, max;
};

// An option in MiB for a value in bytes.
void add_megabytes(CLI::App& app, const std::string& flag, uint64_t& bytes, Range range, const std::string& help) {
  app.add_option_function<uint64_t>(
         flag, [&bytes](uint64_t megabytes) { bytes = megabytes << 20; }, help)
      ->envname(variable_of(flag))
      ->transform(number<uint64_t>(range.min, range.max))
      ->default_str(std::to_string(bytes >> 20));
}

constexpr Range kDerivedMegabytes{0, 1 << 24};

void add_accuracy(CLI::App& app, Accuracy& accuracy) {
  const auto set = [&accuracy](const std::string& name) { accuracy = accuracy_named(name).value(); };
  app.add_option_function<std::string>("--max-accuracy", set, "Highest accuracy of scenes and frames")
      ->envname(variable_of("--max-accuracy"))
      ->check(CLI::IsMember(accuracy_names()))
      ->default_str(name_of(accuracy));
}

void add_client_options(CLI::App& app, ClientLimits& limits) {
  add<uint32_t>(app, "--max-scenes-per-client", limits.max_scenes, 0, 1'000'000,
                "Scenes of one client at once; 0: a quarter of --max-scenes");
  add_megabytes(app, "--max-device-mb-per-client", limits.max_device_bytes, kDerivedMegabytes,
                "MiB that the scenes of one client may hold on their backends; 0: a quarter of --max-device-mb");
  add<uint32_t>(app, "--max-streams-per-client", limits.max_streams, 0, 1'000'000,
                "Streams of one client at once; 0: a quarter of --max-streams");
  add<double>(app, "--max-frames-per-second", limits.max_frames_per_second, 0.01, 1e9,
              "Frames of one client per second");
  add<double>(app, "--max-frame-seconds", limits.max_frame_seconds, 0.001, 1e6,
              "Seconds that a frame may run, not counting the wait for its turn");
  add_accuracy(app, limits.max_accuracy);
}

}  // namespace

void add_limit_options(CLI::App& app, Limits& limits) {
  auto* group = app.add_option_group("Limits", "Requests that exceed them are refused");
  add_megabytes(*group, "--max-message-mb", limits.max_message_bytes, {1, 2047}, "MiB of one received message");
  add_megabytes(*group, "--max-network-mb", limits.max_network_bytes, kDerivedMegabytes,
                "MiB of network buffers, of all connections; 0: an eighth of the memory, at most 512");
  add<uint32_t>(*group, "--max-connections", limits.max_connections, 0, 1'000'000,
                "Connections at once; 0: half of the file descriptors, at most 1024");
  add<uint32_t>(*group, "--max-connections-per-peer", limits.max_connections_per_peer, 0, 1'000'000,
                "Connections at once of one address, or of one user over Unix sockets; 0: as --max-connections");
  add_megabytes(
      *group, "--max-decode-mb", limits.max_decode_bytes, kDerivedMegabytes,
      "MiB of decoded messages, of all open calls, but always enough for the largest message; 0: an eighth of the "
      "memory, at most 256");
  add<uint64_t>(*group, "--max-vertices", limits.max_vertices, 3, 4'294'967'294, "Vertices of one scene");
  add<uint64_t>(*group, "--max-triangles", limits.max_triangles, 1, 1'431'655'764,
                "Triangles, loose edges and points of one scene");
  add<uint32_t>(*group, "--max-scenes", limits.max_scenes, 1, 1'000'000, "Scenes at once");
  add_megabytes(*group, "--max-scene-mb", limits.max_scene_bytes, kDerivedMegabytes,
                "MiB that one scene may hold; 0: as --max-device-mb-per-client");
  add_megabytes(*group, "--max-device-mb", limits.max_device_bytes, kDerivedMegabytes,
                "MiB that all scenes may hold; 0: derived from the memory, half of the host's and at most nine tenths "
                "of the device's");
  add<uint32_t>(*group, "--max-window", limits.max_window, 1, 1024, "Frames in flight on one stream");
  add<uint32_t>(*group, "--max-streams", limits.max_streams, 1, 1'000'000, "Streams at once");
  add<double>(*group, "--max-idle-seconds", limits.max_idle_seconds, 0.1, 1e6,
              "Seconds that a stream may stay open without a frame");
  add<double>(*group, "--max-silent-seconds", limits.max_silent_seconds, 0.1, 1e6,
              "Seconds that a stream may take to open, an upload to its next chunk, a call to its message");
  add<double>(*group, "--lease-seconds", limits.lease_seconds, 0.1, 1e6,
              "Default lease: seconds that a scene outlives its last stream or call");
  add<double>(*group, "--max-lease-seconds", limits.max_lease_seconds, 0.1, 1e6,
              "Longest lease that a scene may request");
  add_client_options(*group, limits.client);
}

}  // namespace collided::server
