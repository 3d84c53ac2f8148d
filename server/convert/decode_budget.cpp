// Memory for the messages of all calls.
#include "server/convert/decode_budget.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <new>
#include <utility>

#include "server/convert/convert.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr double kRetrySeconds = 0.1;  // most messages are worked off by then

[[noreturn]] void throw_used_up(const std::string& subject, uint64_t most, uint64_t taken, uint64_t bytes) {
  throw LimitExceeded::quota(subject,
                             fmt::format("max_decode_bytes leaves {} {} bytes for messages in work; {} are taken, and "
                                         "this message needs {} (option max-decode-mb)",
                                         subject, most, taken, bytes),
                             kRetrySeconds);
}

}  // namespace

DecodeBudget::DecodeBudget(const Limits& limits)
    : most_(std::max(limits.max_decode_bytes, 2 * (limits.max_message_bytes + most_fields(kMaxMeshes) * kFieldBytes))) {
}

// Of one message; given back at its end.
struct DecodeBudget::Share {
  DecodeBudget& budget;
  const std::string client;
  const uint64_t bytes;

  Share(DecodeBudget& budget, std::string client, uint64_t bytes)
      : budget(budget), client(std::move(client)), bytes(bytes) {}
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;
  ~Share() { budget.give_back(client, bytes); }
};

std::shared_ptr<void> DecodeBudget::take(const Client& client, uint64_t bytes) {
  reserve(client->name, bytes);
  try {
    return std::make_shared<Share>(*this, client->name, bytes);
  } catch (const std::bad_alloc&) {
    give_back(client->name, bytes);
    throw;
  }
}

void DecodeBudget::reserve(const std::string& name, uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  const auto client = clients_.find(name);
  const uint64_t of_client = client == clients_.end() ? 0 : client->second;
  if (of_client + bytes > most_ / 2) throw_used_up("client:" + name, most_ / 2, of_client, bytes);
  if (taken_ + bytes > most_) throw_used_up("daemon", most_, taken_, bytes);
  clients_[name] += bytes;
  taken_ += bytes;
}

void DecodeBudget::give_back(const std::string& name, uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  taken_ -= bytes;
  const auto client = clients_.find(name);
  if ((client->second -= bytes) == 0) clients_.erase(client);
}

}  // namespace collided::server
