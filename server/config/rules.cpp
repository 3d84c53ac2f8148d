// Which options go together.
#include "server/config/rules.hpp"

#include <algorithm>
#include <sstream>

#include "server/config/address.hpp"

namespace collided::server {
namespace {

void check_tls(const Config& config) {
  const Tls& tls = config.tls;
  if (tls.certificate.empty() != tls.key.empty())
    throw ConfigError("--tls-certificate and --tls-key must be set together");
  if (!tls.client_ca.empty() && !tls.enabled()) throw ConfigError("--tls-client-ca needs --tls-certificate");
  if (tls.client_ca.empty() || !config.tokens_file.empty()) return;
  constexpr auto kNeedsTokens = ": with --tls-client-ca, a Unix socket needs --tokens-file, too";
  for (const auto& address : config.addresses)
    if (address.starts_with("unix:")) throw ConfigError("--address " + address + kNeedsTokens);
  if (!config.local_socket.empty()) throw ConfigError("--local-socket " + config.local_socket + kNeedsTokens);
}

void check_exposed(const Config& config) {
  if (config.tls.enabled() || config.allow_insecure) return;
  for (const auto& address : config.addresses)
    if (is_public(address))
      throw ConfigError("--address " + address +
                        " is neither loopback nor a Unix socket: it needs --tls-certificate, or --allow-insecure");
}

void check_leases(const Limits& limits) {
  if (limits.lease_seconds <= limits.max_lease_seconds) return;
  std::ostringstream message;
  message << "--lease-seconds is " << limits.lease_seconds << ", more than --max-lease-seconds, "
          << limits.max_lease_seconds;
  throw ConfigError(message.str());
}

bool names(const std::vector<Device>& devices, Backend backend) {
  return std::ranges::any_of(devices, [&](const Device& device) { return device.backend == backend; });
}

void check_devices(const Config& config) {
  std::vector<Device> devices;
  for (const auto& name : config.devices) {
    const Device device = parse_device(name).value();
    if (std::ranges::count(devices, device) > 0) throw ConfigError("--device names " + to_string(device) + " twice");
    devices.push_back(device);
  }
  if (devices.empty()) return;
  if (config.backend == "cpu" && !names(devices, Backend::kCpu))
    throw ConfigError("--backend is cpu, but --device names no device of the CPU");
  if (config.backend == "cuda" && !names(devices, Backend::kCuda))
    throw ConfigError("--backend is cuda, but --device names no CUDA device");
}

}  // namespace

void check_rules(const Config& config) {
  check_tls(config);
  check_exposed(config);
  check_leases(config.limits);
  check_devices(config);
}

std::vector<std::string> exposure_warnings(const Config& config) {
  std::vector<std::string> warnings;
  for (const auto& address : config.addresses) {
    if (!is_public(address)) continue;
    warnings.push_back(
        address +
        " is open to other hosts: this is for networks whose peers do not attack; elsewhere put an entrance "
        "in front (deploy/entrance)");
    if (!config.tls.enabled())
      warnings.push_back(address + " is open to other hosts without TLS: frames and tokens can be read on the way");
    if (config.tokens_file.empty() && config.tls.client_ca.empty())
      warnings.push_back(address + " is open to other hosts, and clients need not authenticate");
  }
  if (!config.http_address.empty() && is_public(config.http_address))
    warnings.push_back("metrics on " + config.http_address + " are open to other hosts without TLS");
  return warnings;
}

}  // namespace collided::server
