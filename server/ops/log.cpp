// Log lines as text or JSON.
#include "server/ops/log.hpp"

#include <signal.h>
#include <spdlog/fmt/chrono.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <utility>

#include "server/ops/line_writer.hpp"

namespace collided::server {
namespace {

using Json = nlohmann::ordered_json;

// The fields of the line that this thread is logging; the sink formats in the same thread.
thread_local std::span<const LogField> fields_of_line;

std::string dump(const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace); }

bool is_plain(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7f && c != '"' && c != '='; });
}

// A value of a text line: quoted and escaped if it could be misread.
std::string quote(const Json& value) {
  if (!value.is_string()) return dump(value);
  const auto& text = value.get_ref<const std::string&>();
  return is_plain(text) ? text : dump(value);
}

// Characters that are not printable ASCII could forge a line, or control the reader's terminal.
std::string escape(std::string_view text) {
  const auto quoted = dump(Json(text));
  std::string escaped;
  for (size_t i = 1; i + 1 < quoted.size(); ++i) {
    const bool quote_mark = quoted[i] == '\\' && (quoted[i + 1] == '"' || quoted[i + 1] == '\\');
    if (quote_mark) ++i;
    escaped += quoted[i] == 0x7f ? std::string("\\u007f") : std::string(1, quoted[i]);
  }
  return escaped;
}

bool is_empty(const LogField& field) {
  const auto* text = std::get_if<std::string_view>(&field.value);
  return text && text->empty();
}

Json value_of(const LogField& field) {
  return std::visit([](const auto& value) { return Json(value); }, field.value);
}

std::string time_of(const spdlog::details::log_msg& line) {
  using std::chrono::milliseconds;
  const auto since = std::chrono::duration_cast<milliseconds>(line.time.time_since_epoch()).count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(spdlog::log_clock::to_time_t(line.time)), since % 1000);
}

std::string text_line(const spdlog::details::log_msg& line) {
  const auto level = spdlog::level::to_string_view(line.level);
  auto text = fmt::format("{} {} {}", time_of(line), level, escape({line.payload.data(), line.payload.size()}));
  for (const auto& field : fields_of_line)
    if (!is_empty(field)) text += fmt::format(" {}={}", field.name, quote(value_of(field)));
  return text + "\n";
}

std::string json_line(const spdlog::details::log_msg& line) {
  const auto level = spdlog::level::to_string_view(line.level);
  Json json;
  json["time"] = time_of(line);
  json["level"] = std::string(level.data(), level.size());
  json["message"] = std::string(line.payload.data(), line.payload.size());
  for (const auto& field : fields_of_line)
    if (!is_empty(field)) json[std::string(field.name)] = value_of(field);
  return dump(json) + "\n";
}

class LineFormatter final : public spdlog::formatter {
 public:
  explicit LineFormatter(bool json) : json_(json) {}

  void format(const spdlog::details::log_msg& line, spdlog::memory_buf_t& out) override {
    const auto text = json_ ? json_line(line) : text_line(line);
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<LineFormatter>(json_); }

 private:
  const bool json_;
};

std::string report_of(uint64_t dropped);

LineWriter& the_writer() {
  static LineWriter& writer = LineWriter::make(STDERR_FILENO, report_of);
  return writer;
}

// Formats in the thread that logs; writes in a thread that nobody waits for.
class WriterSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::string format(const spdlog::details::log_msg& line) {
    spdlog::memory_buf_t text;
    formatter_->format(line, text);
    return {text.data(), text.size()};
  }
  std::string report(uint64_t dropped) {
    const std::lock_guard lock(mutex_);
    const auto text = fmt::format("{} log lines were dropped: nobody read them", dropped);
    return format({"collided", spdlog::level::warn, text});
  }

 private:
  void sink_it_(const spdlog::details::log_msg& line) override { the_writer().write(format(line)); }
  void flush_() override {}
};

WriterSink& the_sink() {
  static const auto sink =
      new std::shared_ptr<WriterSink>(std::make_shared<WriterSink>());  // never destroyed: the writer's thread uses it
  return **sink;
}

std::string report_of(uint64_t dropped) { return the_sink().report(dropped); }

// Created once: other threads may log while main changes format and level.
spdlog::logger& the_logger() {
  static const auto logger = [] {
    // Not owned: it lives until the process ends, as the sink does.
    const std::shared_ptr<WriterSink> sink(&the_sink(), [](auto*) {});
    auto made = std::make_shared<spdlog::logger>("collided", sink);
    made->set_error_handler([](const std::string&) {});  // spdlog's own blocks on stderr
    spdlog::set_default_logger(made);
    std::atexit([] { flush_log(); });
    return made;
  }();
  return *logger;
}

// Hands lines to a function instead of writing them.
class FunctionSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  void set(LineTaker take) {
    const std::lock_guard lock(mutex_);
    take_ = std::move(take);
  }

 private:
  void sink_it_(const spdlog::details::log_msg& line) override {
    std::string text = text_line(line);
    text.pop_back();
    if (take_) take_(line.level, text);
  }
  void flush_() override {}

  LineTaker take_;
};

// Where log_event() logs to; null: nowhere. Loggers are never destroyed, as other threads may be using them.
std::atomic<spdlog::logger*> current_logger = nullptr;

constexpr auto kMoment = std::chrono::milliseconds(500);

extern "C" void flush_and_die(int signal) {
  the_writer().drain_in_signal(kMoment);
  raise(signal);  // the default action has been restored
}

}  // namespace

void set_up_log(const std::string& format, const std::string& level) {
  auto& logger = the_logger();
  for (const auto& sink : logger.sinks()) sink->set_formatter(std::make_unique<LineFormatter>(format == "json"));
  logger.set_level(spdlog::level::from_str(level));
  current_logger = &logger;
}

void send_log_to(spdlog::level::level_enum level, LineTaker take) {
  static const auto sink = new std::shared_ptr<FunctionSink>(std::make_shared<FunctionSink>());
  static const auto logger = [] {
    auto* const made = new spdlog::logger("collided", *sink);
    made->set_error_handler([](const std::string&) {});
    return made;
  }();
  logger->set_level(take ? level : spdlog::level::off);
  (*sink)->set(std::move(take));
  current_logger = logger;
}

void flush_log() { the_writer().drain(kMoment); }

void flush_log_at_crash() {
  the_writer();
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGILL, SIGFPE}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler != SIG_DFL) continue;
    action.sa_handler = flush_and_die;
    action.sa_flags = SA_RESETHAND | SA_NODEFER;
    sigaction(signal, &action, nullptr);
  }
}

void write_line(const std::string& text) try {
  LineWriter& writer = the_writer();
  the_logger();  // registers the flush at exit
  writer.write(text + "\n");
} catch (const std::system_error&) {  // there is no thread for the writer
  std::fputs((text + "\n").c_str(), stderr);
}

uint64_t dropped_log_lines() { return the_writer().dropped(); }

void log_event(spdlog::level::level_enum level, std::string_view message, std::initializer_list<LogField> fields) {
  auto* const logger = current_logger.load();
  if (!logger || !logger->should_log(level)) return;
  fields_of_line = {fields.begin(), fields.size()};
  logger->log(level, spdlog::string_view_t(message.data(), message.size()));
  fields_of_line = {};
}

}  // namespace collided::server
