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
  config.limits.max_message_bytes = kMaxMessageMegabytes << 20;
  for_each_client_limit([](const auto& row, auto& limit) { limit = row.limit_of(row.max); }, config.limits.client);
}

void add_private_sockets(Config& config, const std::string& folder) {
  config.private_folder = folder;
  config.addresses.insert(config.addresses.begin(), "unix:" + folder + "/socket");
  if (config.local_socket == kInItsFolder) config.local_socket = folder + "/local";
  check_rules(config);
}

}  // namespace collided::server
