// Which options may change while the daemon runs.
#include "server/config/reload.hpp"

#include <string>

#include "server/config/private.hpp"

namespace collided::server {
namespace {

// Undoes changes that need a restart, and collects the options' names.
class Keeper {
 public:
  explicit Keeper(std::vector<std::string>& names) : names_(names) {}

  template <class T>
  void keep(const char* name, T& now, const T& before) {
    if (now == before) return;
    names_.push_back(name);
    now = before;
  }

 private:
  std::vector<std::string>& names_;
};

}  // namespace

Reloaded reload_config(int argc, const char* const* argv, const Config& current, const Memory& memory) {
  auto parsed = parse_config(argc, argv);
  if (!parsed.run) throw ConfigError(parsed.text.substr(0, parsed.text.find('\n')));
  Reloaded reloaded{std::move(parsed.config), {}};
  Config& now = reloaded.config;
  if (!current.private_folder.empty()) add_private_sockets(now, current.private_folder);
  derive_limits(now.limits, memory);
  Keeper keeper(reloaded.restart);
  keeper.keep("address", now.addresses, current.addresses);
  keeper.keep("name", now.name, current.name);
  keeper.keep("endpoint", now.endpoint, current.endpoint);
  keeper.keep("http-address", now.http_address, current.http_address);
  keeper.keep("local-socket", now.local_socket, current.local_socket);
  keeper.keep("allow-uid", now.allowed_uids, current.allowed_uids);
  keeper.keep("cuda-ipc", now.cuda_ipc, current.cuda_ipc);
  keeper.keep("ready-file", now.ready_file, current.ready_file);
  keeper.keep("tls-certificate, tls-key or tls-client-ca", now.tls, current.tls);
  if (now.tokens_file.empty()) keeper.keep("tokens-file", now.tokens_file, current.tokens_file);
  keeper.keep("open-reflection", now.open_reflection, current.open_reflection);
  keeper.keep("allow-insecure", now.allow_insecure, current.allow_insecure);
  keeper.keep("backend", now.backend, current.backend);
  keeper.keep("device", now.devices, current.devices);
  keeper.keep("threads", now.threads, current.threads);
  keeper.keep("concurrent-frames", now.concurrent_frames, current.concurrent_frames);
  keeper.keep("keepalive-seconds", now.keepalive_seconds, current.keepalive_seconds);
  keeper.keep("keepalive-timeout-seconds", now.keepalive_timeout_seconds, current.keepalive_timeout_seconds);
  if (const uint64_t calls = max_calls_of_connection(current.limits); max_calls_of_connection(now.limits) > calls)
    reloaded.restart.push_back("max-streams, as to more than " + std::to_string(calls) + " calls of one connection,");
  const auto keep = [&](const auto& row, auto& after, const auto& before) {
    if (row.change == LimitChange::kAfterRestart) keeper.keep(row.option, after, before);
  };
  for_each_limit(keep, now.limits, current.limits);
  return reloaded;
}

}  // namespace collided::server
