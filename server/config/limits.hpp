#pragma once
// The daemon's limits. A limit is a member with its default, and a row beside it: its option, range and help. Options,
// --help, the tokens file, private daemons, SIGHUP and GetServerInfo go over the rows; deploy/README.md and
// deploy/collided.toml are tested against the options.

#include <cstdint>
#include <string>
#include <type_traits>

#include "gpu/types.hpp"

namespace collided::server {

/// Limits of one client; a token may set its own. Scenes, bytes and streams default to a quarter of the daemon's.
struct ClientLimits {
  uint32_t max_scenes = 16;
  uint64_t max_device_bytes = uint64_t{1} << 30;
  uint32_t max_streams = 64;
  double max_frames_per_second = 20'000;
  double max_frame_seconds = 10;  ///< of work on one frame, without the wait for its turn
  Accuracy max_accuracy = Accuracy::kExact;

  bool operator==(const ClientLimits&) const = default;
};

/// All finite. A request that exceeds one is refused, naming the limit. Limits that derive_limits() (memory_limits.hpp)
/// fills default here to its values for a host of 8 GiB.
struct Limits {
  uint64_t max_message_bytes = uint64_t{64} << 20;
  uint64_t max_decode_bytes = uint64_t{256} << 20;  ///< memory of the messages of all calls
  uint64_t max_vertices = 64'000'000;
  uint64_t max_triangles = 128'000'000;
  uint32_t max_scenes = 64;
  uint64_t max_scene_bytes = uint64_t{1} << 30;
  uint64_t max_device_bytes = uint64_t{4} << 30;     ///< of all scenes
  uint64_t max_network_bytes = uint64_t{512} << 20;  ///< gRPC's buffers of all connections
  uint32_t max_connections = 0;                      ///< of gRPC; 0: half of the file descriptors, at most 1,024
  uint32_t max_connections_per_peer = 0;             ///< of an address, or a user over Unix sockets; 0: as many
  uint32_t max_window = 16;
  uint32_t max_streams = 256;
  double max_idle_seconds = 3600;
  double max_silent_seconds = 10;  ///< wait for a stream's opening, a call's message, an upload's next chunk
  double lease_seconds = 30;       ///< of scenes that request none
  double max_lease_seconds = 3600;
  ClientLimits client;

  bool operator==(const Limits&) const = default;
};

/// The most that --max-message-mb can set. No protobuf message is larger.
inline constexpr uint64_t kMaxMessageMegabytes = 2047;

/// How the value of an option becomes a limit.
enum class LimitUnit { kOne, kMegabytes };
/// When SIGHUP changes a limit.
enum class LimitChange { kAtOnce, kAfterRestart };

/// The option of a limit. Its key in the configuration file is its flag without the dashes.
template <class T>
struct LimitRow {
  const char* option;
  T min, max;  ///< in the option's unit
  const char* help;
  LimitUnit unit = LimitUnit::kOne;
  LimitChange change = LimitChange::kAtOnce;

  std::string flag() const { return std::string("--") + option; }
  /// True if derive_limits(), or the system, gives the value where it is not set. The option's 0 means that.
  constexpr bool is_derived() const { return std::is_arithmetic_v<T> && min == T{}; }
  /// Returns the limit for a value of the option.
  constexpr T limit_of(T value) const {
    if constexpr (std::is_same_v<T, uint64_t>) return unit == LimitUnit::kMegabytes ? value << 20 : value;
    return value;
  }
};

namespace detail {

using Count = LimitRow<uint32_t>;
using Number = LimitRow<uint64_t>;
using Real = LimitRow<double>;

inline constexpr uint32_t kMaxCount = 1'000'000;
inline constexpr double kMaxSeconds = 1e6;

constexpr Number megabytes(const char* option, const char* help, LimitChange change = LimitChange::kAtOnce) {
  return {option, 0, 1 << 24, help, LimitUnit::kMegabytes, change};
}

}  // namespace detail

/// Calls visit(row, value of each of `limits`) for each limit of a client, in the order of --help.
template <class Visit, class... AllLimits>
constexpr void for_each_client_limit(const Visit& visit, AllLimits&&... limits) {
  using namespace detail;
  visit(Count{"max-scenes-per-client", 0, kMaxCount, "Scenes of one client at once; 0: a quarter of --max-scenes"},
        limits.max_scenes...);
  visit(megabytes("max-device-mb-per-client",
                  "MiB that the scenes of one client may hold on their backends; 0: a quarter of --max-device-mb"),
        limits.max_device_bytes...);
  visit(Count{"max-streams-per-client", 0, kMaxCount, "Streams of one client at once; 0: a quarter of --max-streams"},
        limits.max_streams...);
  visit(Real{"max-frames-per-second", 0.01, 1e9, "Frames of one client per second"}, limits.max_frames_per_second...);
  visit(
      Real{"max-frame-seconds", 0.001, kMaxSeconds, "Seconds that a frame may run, not counting the wait for its turn"},
      limits.max_frame_seconds...);
  visit(LimitRow<Accuracy>{"max-accuracy", Accuracy::kCandidates, Accuracy::kExact,
                           "Highest accuracy of scenes and frames"},
        limits.max_accuracy...);
}

/// Calls visit(row, value of each of `limits`) for each limit, those of a client last.
template <class Visit, class... AllLimits>
constexpr void for_each_limit(const Visit& visit, AllLimits&&... limits) {
  using namespace detail;
  constexpr auto kAfterRestart = LimitChange::kAfterRestart;
  visit(Number{"max-message-mb", 1, kMaxMessageMegabytes, "MiB of one received message", LimitUnit::kMegabytes,
               kAfterRestart},
        limits.max_message_bytes...);
  visit(megabytes("max-network-mb",
                  "MiB of network buffers, of all connections; 0: an eighth of the memory, at most 512", kAfterRestart),
        limits.max_network_bytes...);
  visit(Count{"max-connections", 0, kMaxCount, "Connections at once; 0: half of the file descriptors, at most 1024"},
        limits.max_connections...);
  visit(Count{"max-connections-per-peer", 0, kMaxCount,
              "Connections at once of one address, or of one user over Unix sockets; 0: as --max-connections"},
        limits.max_connections_per_peer...);
  visit(megabytes("max-decode-mb",
                  "MiB of decoded messages, of all open calls, but always enough for the largest message; 0: an eighth "
                  "of the memory, at most 256",
                  kAfterRestart),
        limits.max_decode_bytes...);
  visit(Number{"max-vertices", 3, 4'294'967'294, "Vertices of one scene"}, limits.max_vertices...);
  visit(Number{"max-triangles", 1, 1'431'655'764, "Triangles, loose edges and points of one scene"},
        limits.max_triangles...);
  visit(Count{"max-scenes", 1, kMaxCount, "Scenes at once"}, limits.max_scenes...);
  visit(megabytes("max-scene-mb", "MiB that one scene may hold; 0: as --max-device-mb-per-client"),
        limits.max_scene_bytes...);
  visit(megabytes("max-device-mb",
                  "MiB that all scenes may hold; 0: derived from the memory, half of the host's and at most nine "
                  "tenths of the device's"),
        limits.max_device_bytes...);
  visit(Count{"max-window", 1, 1024, "Frames in flight on one stream"}, limits.max_window...);
  visit(Count{"max-streams", 1, kMaxCount, "Streams at once"}, limits.max_streams...);
  visit(Real{"max-idle-seconds", 0.1, kMaxSeconds, "Seconds that a stream may stay open without a frame"},
        limits.max_idle_seconds...);
  visit(Real{"max-silent-seconds", 0.1, kMaxSeconds,
             "Seconds that a stream may take to open, an upload to its next chunk, a call to its message"},
        limits.max_silent_seconds...);
  visit(Real{"lease-seconds", 0.1, kMaxSeconds, "Default lease: seconds that a scene outlives its last stream or call"},
        limits.lease_seconds...);
  visit(Real{"max-lease-seconds", 0.1, kMaxSeconds, "Longest lease that a scene may request"},
        limits.max_lease_seconds...);
  for_each_client_limit(visit, limits.client...);
}

}  // namespace collided::server
