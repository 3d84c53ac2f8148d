// The ids of a call, from its headers.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <random>

#include "server/ops/log.hpp"

namespace collided::server {
namespace {

constexpr size_t kMaxRequestId = 64;

bool is_request_id(std::string_view text) {
  return !text.empty() && text.size() <= kMaxRequestId &&
         std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7f; });
}

std::string random_id() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return fmt::format("{:016x}{:016x}", random(), random());
}

bool is_hex(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_zero(std::string_view text) { return text.find_first_not_of('0') == std::string_view::npos; }

// version-trace-parent-flags, 2, 32, 16 and 2 digits; versions after 00 may append more after another dash.
bool is_traceparent(std::string_view text) {
  constexpr size_t kSize = 55;
  if (text.size() < kSize || text[2] != '-' || text[35] != '-' || text[52] != '-') return false;
  const auto version = text.substr(0, 2), trace = text.substr(3, 32), parent = text.substr(36, 16);
  if (!is_hex(version) || !is_hex(trace) || !is_hex(parent) || !is_hex(text.substr(53, 2))) return false;
  if (version == "ff" || is_zero(trace) || is_zero(parent)) return false;
  return text.size() == kSize || (version != "00" && text[kSize] == '-');
}

}  // namespace

CallIds parse_ids(std::string_view request_id_header, std::string_view traceparent_header) {
  CallIds ids;
  ids.request_id = is_request_id(request_id_header) ? std::string(request_id_header) : random_id();
  if (is_traceparent(traceparent_header)) {
    ids.trace_id = traceparent_header.substr(3, 32);
    ids.parent_id = traceparent_header.substr(36, 16);
  }
  return ids;
}

}  // namespace collided::server
