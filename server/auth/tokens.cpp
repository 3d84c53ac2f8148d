// The file of bearer tokens.
#include "server/auth/tokens.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "server/auth/secret_file.hpp"
#include "server/config/accuracy_names.hpp"
#include "server/config/file/text_file.hpp"
#include "server/config/file/toml_value.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFileBytes = 4 << 20;
constexpr size_t kMaxTokens = 1'000, kMaxName = 64, kMinToken = 16, kMaxToken = 512;
constexpr std::string_view kOfClients = "-per-client";

// All limits of a token are its client's, so its keys need not say so.
std::string key_of(std::string_view option) {
  if (option.ends_with(kOfClients)) option.remove_suffix(kOfClients.size());
  return std::string(option);
}

std::vector<std::string> token_keys() {
  std::vector<std::string> keys = {"name", "token", "sha256"};
  for_each_client_limit([&](const auto& row) { keys.push_back(key_of(row.option)); });
  return keys;
}

// One [[tokens]], with its line for error messages.
class Entry {
 public:
  Entry(const std::string& path, const toml::value& value)
      : where_(path + ":" + std::to_string(line_of(value)) + ": "), value_(value) {
    if (!value.is_table()) refuse("tokens must be tables: [[tokens]]");
    const auto keys = token_keys();
    for (const auto& [key, unused] : value.as_table())
      if (std::ranges::find(keys, key) == keys.end()) refuse(unknown_key(keys));
  }

  Token read(const ClientLimits& defaults) const {
    ClientIdentity client{text("name", 1, kMaxName), defaults};
    if (client.name == ClientIdentity().name)
      refuse("name is \"anonymous\", which is reserved for callers without one");
    set_limits(client.limits);
    return {digest(), std::make_shared<const ClientIdentity>(std::move(client))};
  }

  [[noreturn]] void refuse(const std::string& what) const { throw ConfigError(where_ + what); }

 private:
  // A key may be a token that was put in the wrong place, so it is not quoted.
  static std::string unknown_key(const std::vector<std::string>& keys) {
    std::string what = "has a key that no token has; there are";
    for (const std::string& key : keys) what.append(key == keys[0] ? " " : ", ").append(key);
    return what;
  }

  bool has(const std::string& key) const { return value_.contains(key); }

  std::string text(const std::string& key, size_t min, size_t max) const {
    if (!has(key) || !value_.at(key).is_string()) refuse(key + " is not a string");
    const std::string text = text_in(value_.at(key));
    if (text.size() < min || text.size() > max)
      refuse(key + " has " + std::to_string(text.size()) + " bytes, not " + std::to_string(min) + " to " +
             std::to_string(max));
    if (!std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7f; }))
      refuse(key + " must have printable ASCII characters only, and no blanks");
    return text;
  }

  Digest digest() const {
    if (has("token") == has("sha256")) refuse("one of token and sha256 is needed");
    if (has("token")) return digest_of(text("token", kMinToken, kMaxToken));
    const auto digits = text("sha256", 64, 64);
    if (digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      refuse("sha256 must have hexadecimal digits only");
    Digest digest;
    for (size_t i = 0; i < digest.size(); ++i)
      digest[i] = static_cast<unsigned char>(std::stoul(digits.substr(2 * i, 2), nullptr, 16));
    if (digest == digest_of("")) refuse("sha256 is that of an empty string, which is no token");
    return digest;
  }

  double number(const std::string& key, double min, double max) const {
    const auto& value = value_.at(key);
    if (!value.is_integer() && !value.is_floating()) refuse(key + " is not a number");
    const double number = value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
    if (number >= min && number <= max) return number;
    std::ostringstream what;
    what << key << " is " << number << ", not " << min << " to " << max;
    refuse(what.str());
  }

  // Nothing of a token's limit is derived: 0 is no number that it may have.
  template <class T>
  T limit(const std::string& key, const LimitRow<T>& row) const {
    const double number = this->number(key, 1, static_cast<double>(row.max));
    if (number != std::floor(number)) refuse(key + " is not a whole number");
    return row.limit_of(static_cast<T>(number));
  }

  double limit(const std::string& key, const LimitRow<double>& row) const { return number(key, row.min, row.max); }

  Accuracy limit(const std::string& key, const LimitRow<Accuracy>&) const {
    const auto named = accuracy_named(text(key, 1, kMaxName));
    if (!named) refuse(key + " must be candidates, fast, guarded, certified or exact");
    return *named;
  }

  void set_limits(ClientLimits& limits) const {
    const auto set = [this](const auto& row, auto& value) {
      if (const std::string key = key_of(row.option); has(key)) value = limit(key, row);
    };
    for_each_client_limit(set, limits);
  }

  std::string where_;
  const toml::value& value_;
};

// toml11's own messages quote the line, which may contain a token.
toml::value parse_toml(const std::string& path) try {
  std::istringstream text(read_toml_text(path, kMaxFileBytes));
  return toml::parse(text, path);
} catch (const TomlError& error) {
  throw ConfigError(path + ":" + std::to_string(line_of(error)) + ": is not valid TOML");
} catch (const ConfigError&) {
  throw;
} catch (const std::exception&) {
  throw ConfigError(path + ": is not valid TOML");
}

const toml::array& entries_of(const toml::value& root, const std::string& path) {
  for (const auto& [key, value] : root.as_table())  // a key may be a token that was put in the wrong place
    if (key != "tokens")
      throw ConfigError(path + ":" + std::to_string(line_of(value)) +
                        ": has a key that is not one of the file's; tokens are written as [[tokens]]");
  if (!root.contains("tokens") || !root.at("tokens").is_array() || root.at("tokens").as_array().empty())
    throw ConfigError(path + ": has no [[tokens]]");
  const auto& entries = root.at("tokens").as_array();
  if (entries.size() > kMaxTokens)
    throw ConfigError(path + ": has " + std::to_string(entries.size()) + " tokens, more than " +
                      std::to_string(kMaxTokens));
  return entries;
}

// A name may occur again, so that its token can be replaced without a gap, but not with other limits.
void check_new(const Token& token, const std::vector<Token>& before, const Entry& entry) {
  for (const auto& other : before) {
    if (other.digest == token.digest) entry.refuse("the token of " + token.client->name + " appears twice");
    if (other.client->name == token.client->name && other.client->limits != token.client->limits)
      entry.refuse("the tokens of " + token.client->name + " have different limits");
  }
}

}  // namespace

Digest digest_of(std::string_view token) {
  Digest digest;
  if (EVP_Digest(token.data(), token.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("OpenSSL has no SHA-256");
  return digest;
}

std::vector<Token> read_tokens(const std::string& path, const ClientLimits& defaults) {
  const auto root = parse_toml(path);
  std::vector<Token> tokens;
  for (const auto& value : entries_of(root, path)) {
    const Entry entry(path, value);
    auto token = entry.read(defaults);
    check_new(token, tokens, entry);
    tokens.push_back(std::move(token));
  }
  warn_if_others_can_read(path);
  return tokens;
}

}  // namespace collided::server
