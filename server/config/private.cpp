#include "server/config/private.hpp"

#include "server/config/host_limits.hpp"
#include "server/config/rules.hpp"

namespace collided::server {
namespace {

constexpr auto kInItsFolder = "local";  // no option can name a relative path

}  // namespace

void set_private_defaults(Config& config) {
  config.addresses.clear();
  if (overcommits_memory()) config.local_socket = kInItsFolder;
  config.log_level = "warning";
  config.limits.max_message_bytes = uint64_t{2047} << 20;
  config.limits.client = {.max_scenes = 1'000'000,
                          .max_device_bytes = uint64_t{1 << 24} << 20,
                          .max_streams = 1'000'000,
                          .max_frames_per_second = 1e9,
                          .max_frame_seconds = 1e6};
}

void add_private_sockets(Config& config, const std::string& folder) {
  config.private_folder = folder;
  config.addresses.insert(config.addresses.begin(), "unix:" + folder + "/socket");
  if (config.local_socket == kInItsFolder) config.local_socket = folder + "/local";
  check_rules(config);
}

}  // namespace collided::server
