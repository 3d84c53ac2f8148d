// The file of bearer tokens.
#include "server/auth/tokens.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "server/auth/secret_file.hpp"
#include "server/config/accuracy_names.hpp"
#include "server/config/file/text_file.hpp"
#include "server/config/file/toml_value.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFileBytes = 4 << 20;
constexpr size_t kMaxTokens = 1'000, kMaxName = 64, kMinToken = 16, kMaxToken = 512;
constexpr double kMaxCount = 1'000'000, kMaxMegabytes = 1 << 24, kMaxRate = 1e9, kMaxFrameSeconds = 1e6;

// One [[tokens]], with its line for error messages.
class Entry {
 public:
  Entry(const std::string& path, const toml::value& value)
      : where_(path + ":" + std::to_string(line_of(value)) + ": "), value_(value) {
    if (!value.is_table()) refuse("tokens must be tables: [[tokens]]");
    for (const auto& [key, unused] : value.as_table())
      if (std::ranges::find(kKeys, key) == std::end(kKeys)) refuse(unknown_key());
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
  static constexpr std::string_view kKeys[] = {"name",
                                               "token",
                                               "sha256",
                                               "max-scenes",
                                               "max-device-mb",
                                               "max-streams",
                                               "max-frames-per-second",
                                               "max-frame-seconds",
                                               "max-accuracy"};

  // A key may be a token that was put in the wrong place, so it is not quoted.
  static std::string unknown_key() {
    std::string what = "has a key that no token has; there are";
    for (const std::string_view key : kKeys) what.append(key == kKeys[0] ? " " : ", ").append(key);
    return what;
  }

  bool has(const char* key) const { return value_.contains(key); }

  std::string text(const char* key, size_t min, size_t max) const {
    if (!has(key) || !value_.at(key).is_string()) refuse(std::string(key) + " is not a string");
    const std::string text = text_in(value_.at(key));
    if (text.size() < min || text.size() > max)
      refuse(std::string(key) + " has " + std::to_string(text.size()) + " bytes, not " + std::to_string(min) + " to " +
             std::to_string(max));
    if (!std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7f; }))
      refuse(std::string(key) + " must have printable ASCII characters only, and no blanks");
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

  double number(const char* key, double min, double max) const {
    const auto& value = value_.at(key);
    if (!value.is_integer() && !value.is_floating()) refuse(std::string(key) + " is not a number");
    const double number = value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
    if (number >= min && number <= max) return number;
    std::ostringstream what;
    what << key << " is " << number << ", not " << min << " to " << max;
    refuse(what.str());
  }

  Accuracy accuracy() const {
    const auto named = accuracy_named(text("max-accuracy", 1, kMaxName));
    if (!named) refuse("max-accuracy must be candidates, fast, guarded, certified or exact");
    return *named;
  }

  uint64_t count(const char* key, double max) const {
    const double number = this->number(key, 1, max);
    if (number != std::floor(number)) refuse(std::string(key) + " is not a whole number");
    return static_cast<uint64_t>(number);
  }

  void set_limits(ClientLimits& limits) const {
    if (has("max-scenes")) limits.max_scenes = static_cast<uint32_t>(count("max-scenes", kMaxCount));
    if (has("max-device-mb")) limits.max_device_bytes = count("max-device-mb", kMaxMegabytes) << 20;
    if (has("max-streams")) limits.max_streams = static_cast<uint32_t>(count("max-streams", kMaxCount));
    if (has("max-frame-seconds")) limits.max_frame_seconds = number("max-frame-seconds", 0.001, kMaxFrameSeconds);
    if (has("max-accuracy")) limits.max_accuracy = accuracy();
    if (has("max-frames-per-second")) limits.max_frames_per_second = number("max-frames-per-second", 0.01, kMaxRate);
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
