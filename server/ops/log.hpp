#pragma once
// Log lines as text or JSON, with the ids of the call, scene and frame they belong to.

#include <spdlog/common.h>

#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

namespace collided::server {

/// Log lines go to stderr in the order in which they were logged. Nobody waits for stderr: if it blocks, lines are
/// dropped and counted once 1 MiB waits, and a line says how many once it accepts data again. `format`: text or json;
/// `level`: as spdlog names them. May be called again at any time.
void set_up_log(const std::string& format, const std::string& level);

/// Takes a line of text, without its end, from any thread, one at a time. It must not log.
using LineTaker = std::function<void(spdlog::level::level_enum level, const std::string& line)>;
/// Log lines go to `take` instead, as text; null: nowhere, which is also where they go before either is called. Neither
/// stderr nor spdlog's default logger is touched. Once this has returned, the function that was set before is not
/// running.
void send_log_to(spdlog::level::level_enum level, LineTaker take);

/// Waits until all lines are written, for at most half a second. Happens by itself when the process exits.
void flush_log();
/// From now on, a process that dies of a fault or of abort() first writes its lines, for at most half a second.
void flush_log_at_crash();
/// Writes a line verbatim, without time and level, in order with the others.
void write_line(const std::string& text);
/// Lines dropped since the start.
uint64_t dropped_log_lines();

/// The ids of one call. All are empty or printable ASCII without blanks.
struct CallIds {
  std::string request_id;  ///< never empty after parse_ids, at most 64 bytes
  std::string trace_id;    ///< 32 hexadecimal digits of a valid traceparent; else empty
  std::string parent_id;   ///< 16 hexadecimal digits; else empty
};

/// From the headers `x-request-id` and `traceparent` (W3C Trace Context); empty: not sent. Invalid ids are dropped, and
/// a missing request id is replaced by a random one.
CallIds parse_ids(std::string_view request_id_header, std::string_view traceparent_header);

/// A named value of a log line. Does not own its string.
struct LogField {
  template <std::signed_integral T>
  LogField(std::string_view key, T number) : name(key), value(int64_t{number}) {}
  template <std::unsigned_integral T>
  LogField(std::string_view key, T number) : name(key), value(uint64_t{number}) {}
  LogField(std::string_view key, double number) : name(key), value(number) {}
  LogField(std::string_view key, std::string_view text) : name(key), value(text) {}
  LogField(std::string_view key, const std::string& text) : name(key), value(std::string_view(text)) {}
  LogField(std::string_view key, const char* text) : name(key), value(std::string_view(text)) {}

  std::string_view name;
  std::variant<int64_t, uint64_t, double, std::string_view> value;
};

/// One line: `message scene=.. frame=..`, or one JSON object. Empty strings are left out. The usual names are scene,
/// frame, request, trace, client.
void log_event(spdlog::level::level_enum level, std::string_view message, std::initializer_list<LogField> fields);

}  // namespace collided::server
