// Memory for the messages of all calls.
#include "server/limits/decode_budget.hpp"

#include <spdlog/fmt/fmt.h>

#include <new>
#include <utility>

#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr double kRetrySeconds = 0.1;  // most messages are done by then

[[noreturn]] void throw_used_up(const std::string& subject, uint64_t max, uint64_t taken, uint64_t bytes) {
  throw LimitExceeded::quota(subject,
                             fmt::format("max_decode_bytes leaves {} {} bytes for decoded messages; {} are taken, and "
                                         "this message needs {} (option max-decode-mb)",
                                         subject, max, taken, bytes),
                             kRetrySeconds);
}

}  // namespace

// One message's reservation.
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
  if (of_client + bytes > max_ / 2) throw_used_up("client:" + name, max_ / 2, of_client, bytes);
  if (taken_ + bytes > max_) throw_used_up("daemon", max_, taken_, bytes);
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
