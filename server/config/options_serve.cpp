// Options of where and how the daemon serves.
#include <algorithm>
#include <string>

#include "server/config/address.hpp"
#include "server/config/options.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxNameBytes = 63;  // as of a host's name

// An empty value turns the option off.
CLI::Validator or_empty(std::string (*check)(const std::string&)) {
  return CLI::Validator([check](std::string& text) { return text.empty() ? std::string() : check(text); }, "");
}

// What ends a name in an id is no part of one.
std::string check_name(const std::string& name) {
  const bool is_short = name.size() <= kMaxNameBytes;
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  if (is_short && std::all_of(name.begin(), name.end(), is_allowed)) return {};
  return "it must have at most " + std::to_string(kMaxNameBytes) + " letters, digits, '-' and '_'";
}

std::string check_device_id(const std::string& text) {
  return parse_device(text) ? "" : "\"" + text + "\" names no device: it must be as cuda:0 or cpu:0";
}

void add_addresses(CLI::App& app, Config& config) {
  add(app, "--address", config.addresses, "host:port (port 0: any free one) or unix:/path; may be repeated")
      ->type_name("ADDRESS")
      ->delimiter(',')
      ->check(CLI::Validator(check_address, ""));
  add(app, "--name", config.name, "Name that begins the ids of its scenes, for proxies that route by them; empty: none")
      ->type_name("NAME")
      ->check(or_empty(check_name));
  add(app, "--endpoint", config.endpoint, "Address advertised to clients for streaming; empty: the one they used")
      ->type_name("ADDRESS")
      ->check(or_empty(check_address));
  add(app, "--http-address", config.http_address, "host:port of /metrics, /readyz and /healthz; empty: off")
      ->type_name("ADDRESS")
      ->check(or_empty(check_http_address));
  add(app, "--local-socket", config.local_socket,
      "Path of the socket for clients on this host that share memory; empty: off")
      ->type_name("FILE")
      ->check(or_empty(check_socket_path));
  add(app, "--allow-uid", config.allowed_uids,
      "User that may use the local socket besides the daemon's own; may be repeated")
      ->delimiter(',')
      ->transform(number<uint32_t>(0, 4'294'967'294));
  add_switch(app, "--cuda-ipc", config.cuda_ipc, "Accept device memory of clients on the same GPU");
  add(app, "--ready-file", config.ready_file,
      "File that receives the bound addresses once the daemon serves; empty: none")
      ->type_name("FILE");
}

void add_security(CLI::App& app, Config& config) {
  add(app, "--tls-certificate", config.tls.certificate, "PEM file of the certificate chain; empty: plain text")
      ->type_name("FILE");
  add(app, "--tls-key", config.tls.key, "PEM file of its private key")->type_name("FILE");
  add(app, "--tls-client-ca", config.tls.client_ca,
      "PEM file of the CAs that sign client certificates, which are then required")
      ->type_name("FILE");
  add(app, "--tokens-file", config.tokens_file, "TOML file of clients' bearer tokens; empty: none")->type_name("FILE");
  add_switch(app, "--open-reflection", config.open_reflection,
             "Serve reflection to callers without a token or certificate, too");
  add_switch(app, "--allow-insecure", config.allow_insecure,
             "Allow plain text on addresses that other hosts can reach");
}

void add_engine(CLI::App& app, Config& config) {
  add(app, "--backend", config.backend, "Default backend of scenes: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}));
  add(app, "--device", config.devices,
      "Device that scenes can live on: cuda:0, cuda:1, ..., or cpu:0; may be repeated; none: every CUDA device and the "
      "CPU")
      ->type_name("DEVICE")
      ->delimiter(',')
      ->check(CLI::Validator(check_device_id, ""));
  add<int>(app, "--threads", config.threads, 0, 4096,
           "CPU threads of a scene; 0: all cores, shared by the devices of the CPU");
  add<int>(app, "--concurrent-frames", config.concurrent_frames, 0, 4096,
           "Frames of different scenes computed at once on a device; 0: 4 to 12 on a GPU, else 2");
}

void add_times(CLI::App& app, Config& config) {
  add<double>(app, "--grace-seconds", config.grace_seconds, 0, 3600,
              "Seconds that open streams have left when the daemon stops");
  add<double>(app, "--keepalive-seconds", config.keepalive_seconds, 1, 7200,
              "Seconds between pings to a silent client");
  add<double>(app, "--keepalive-timeout-seconds", config.keepalive_timeout_seconds, 0.1, 600,
              "Seconds until a client that does not answer a ping is dropped");
}

void add_log(CLI::App& app, Config& config) {
  add(app, "--log-level", config.log_level, "Minimum severity of log lines")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "critical", "off"}));
  add(app, "--log-format", config.log_format, "text, or json: one object per line")
      ->check(CLI::IsMember({"text", "json"}));
}

}  // namespace

void add_serve_options(CLI::App& app, Config& config) {
  add_addresses(*app.add_option_group("Addresses"), config);
  add_security(*app.add_option_group("Security"), config);
  add_engine(*app.add_option_group("Engine"), config);
  add_times(*app.add_option_group("Time"), config);
  add_log(*app.add_option_group("Log"), config);
}

}  // namespace collided::server
