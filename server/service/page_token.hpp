#pragma once
// Page tokens of ListScenes.

#include <algorithm>
#include <string>

#include "server/refusals/refuse.hpp"
#include "server/shorten.hpp"

namespace collided::server {

/// Tokens are ids of scenes, which may have been deleted. `daemon`: its name, which they begin with; may be empty.
/// Throws InvalidInput.
inline void check_page_token(const std::string& token, const std::string& daemon) {
  constexpr size_t kDigits = 32;
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  const std::string begin = daemon.empty() ? "" : daemon + ".";
  const bool is_id = token.size() == begin.size() + kDigits && token.starts_with(begin) &&
                     std::all_of(token.end() - kDigits, token.end(), is_digit);
  if (!token.empty() && !is_id)
    throw_invalid("page_token",
                  fmt::format("is \"{}\", but must be the next_page_token of an answer", shorten(token, 64)));
}

}  // namespace collided::server
