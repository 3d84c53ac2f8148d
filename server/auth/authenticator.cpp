// Finds the client of a call by its credentials.
#include "server/auth/authenticator.hpp"

#include <strings.h>

#include <string>
#include <utility>
#include <vector>

#include "server/auth/secrets.hpp"
#include "server/auth/tokens.hpp"
#include "server/errors.hpp"

namespace collided::server {

struct ClientTable {
  std::vector<Token> tokens;  ///< empty: none is required
  bool certificates = false;  ///< the name of the certificate is the client
  ClientLimits limits;
};

namespace {

std::shared_ptr<const ClientTable> read_table(const Config& config) {
  auto table = std::make_shared<ClientTable>();
  const auto& limits = config.limits.client;
  if (!config.tokens_file.empty()) table->tokens = read_tokens(config.tokens_file, limits);
  table->certificates = !config.tls.client_ca.empty();
  table->limits = limits;
  return table;
}

std::string_view token_of(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (authorization.empty()) throw Unauthenticated("authorization is missing: the daemon requires a bearer token");
  if (authorization.size() < kScheme.size() || strncasecmp(authorization.data(), kScheme.data(), kScheme.size()) != 0)
    throw Unauthenticated("authorization is not \"Bearer\" and a token");
  const auto start = authorization.find_first_not_of(' ', kScheme.size());
  if (start == std::string_view::npos) throw Unauthenticated("authorization has no token after \"Bearer\"");
  return authorization.substr(start);
}

std::string_view text_of(const Digest& digest) { return {reinterpret_cast<const char*>(digest.data()), digest.size()}; }

// In constant time, whichever token matches, or none.
Client find(const std::vector<Token>& tokens, std::string_view token) {
  const auto digest = digest_of(token);
  const Token* found = nullptr;
  for (const auto& known : tokens)
    if (is_equal_secret(text_of(known.digest), text_of(digest))) found = &known;
  if (!found) throw Unauthenticated("the bearer token is not known");
  return found->client;
}

// Anonymous callers share a name and its limits, but each origin takes turns of its own.
Client anonymous(const ClientTable& table, const Origin& origin) {
  ClientIdentity client{.limits = table.limits};
  if (!origin.party.empty()) client.turns = {origin.party, origin.member};
  return std::make_shared<const ClientIdentity>(std::move(client));
}

}  // namespace

Authenticator::Authenticator(const Config& config) : table_(read_table(config)) {}
Authenticator::~Authenticator() = default;

Client Authenticator::identify(std::string_view authorization, std::string_view certificate_name,
                               const Origin& origin) const {
  const auto now = table();
  if (!now->tokens.empty()) return find(now->tokens, token_of(authorization));
  if (!now->certificates) return anonymous(*now, origin);
  if (certificate_name.empty()) throw Unauthenticated("the daemon requires a certificate with a name");
  return std::make_shared<const ClientIdentity>(ClientIdentity{std::string(certificate_name), now->limits});
}

void Authenticator::reload(const Config& config) {
  auto table = read_table(config);
  std::lock_guard lock(mutex_);
  table_ = std::move(table);
}

std::shared_ptr<const ClientTable> Authenticator::table() const {
  std::lock_guard lock(mutex_);
  return table_;
}

}  // namespace collided::server
