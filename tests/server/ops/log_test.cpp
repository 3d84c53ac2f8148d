// Log lines, and the ids of calls.
#include "server/ops/log.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

namespace collided::server {
namespace {

constexpr auto kInfo = spdlog::level::info;

template <class Body>
std::string logged(const std::string& format, const std::string& level, const Body& body) {
  set_up_log(format, level);
  testing::internal::CaptureStderr();
  body();
  flush_log();
  return testing::internal::GetCapturedStderr();
}

TEST(Log, TextHasTimeLevelMessageAndFields) {
  const auto line = logged("text", "info", [] {
    log_event(kInfo, "frame done", {{"scene", "s-1"}, {"frame", uint64_t{7}}, {"seconds", 0.5}, {"trace", ""}});
  });
  EXPECT_TRUE(std::regex_match(
      line, std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z info frame done scene=s-1 frame=7 seconds=0.5\n)")))
      << line;
}

TEST(Log, JsonIsOneObjectALine) {
  const auto line = logged("json", "info", [] {
    log_event(spdlog::level::err, "frame \"refused\"",
              {{"scene", "a\nb\xff"}, {"frame", std::numeric_limits<uint64_t>::max()}, {"mesh", -1}, {"x", NAN}});
  });
  EXPECT_EQ(std::ranges::count(line, '\n'), 1);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["level"], "error");
  EXPECT_EQ(json["message"], "frame \"refused\"");
  EXPECT_EQ(json["scene"], "a\nb\uFFFD");
  EXPECT_EQ(json["frame"], std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(json["mesh"], -1);
  EXPECT_TRUE(json["x"].is_null());
}

TEST(Log, NobodyForgesALine) {
  const std::string hostile = "x\n2026-01-01T00:00:00.000Z info all is well scene=\"1\"\r\x1b[2J\x7f\xc2\x9b";
  for (const auto* format : {"text", "json"}) {
    const auto line = logged(format, "info", [&] {
      log_event(kInfo, hostile, {{"scene", hostile}});
      spdlog::info("plain {}", hostile);
    });
    EXPECT_EQ(std::ranges::count(line, '\n'), 2) << line;
    for (const char c : {'\r', '\x1b', '\xc2', '\x9b'}) EXPECT_EQ(line.find(c), std::string::npos) << line;
  }
  const auto text = logged("text", "info", [&] { log_event(kInfo, "m", {{"a", "b scene=2"}, {"c", "\"d"}}); });
  EXPECT_NE(text.find(" m a=\"b scene=2\" c=\"\\\"d\"\n"), std::string::npos) << text;
}

TEST(Log, PlainLinesTakeTheFormatButNoFields) {
  const auto lines = logged("json", "info", [] {
    log_event(kInfo, "first", {{"scene", "1"}});
    spdlog::info("second");
  });
  const auto second = nlohmann::json::parse(lines.substr(lines.find('\n') + 1));
  EXPECT_EQ(second["message"], "second");
  EXPECT_FALSE(second.contains("scene"));
}

TEST(Log, LevelsAreKept) {
  const auto write = [] {
    log_event(kInfo, "low", {});
    log_event(spdlog::level::warn, "high", {});
  };
  const auto lines = logged("text", "warning", write);
  EXPECT_EQ(lines.find("low"), std::string::npos);
  EXPECT_NE(lines.find("high"), std::string::npos);
  EXPECT_EQ(logged("text", "off", write), "");
}

constexpr auto* kTrace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";

TEST(CallIds, KeepWhatTheCallerSent) {
  const auto ids = parse_ids("request-1", kTrace);
  EXPECT_EQ(ids.request_id, "request-1");
  EXPECT_EQ(ids.trace_id, "0af7651916cd43dd8448eb211c80319c");
  EXPECT_EQ(ids.parent_id, "b7ad6b7169203331");
}

TEST(CallIds, MakeARequestIdWhereNoneIsUsable) {
  for (const std::string& sent : {std::string(), std::string(65, 'a'), std::string("a b"), std::string("a\nb"),
                                  std::string("\xc3\xa4"), std::string("a\0b", 3)}) {
    const auto made = parse_ids(sent, "").request_id;
    EXPECT_EQ(made.size(), 32u) << sent;
    EXPECT_NE(made, parse_ids(sent, "").request_id);
  }
  EXPECT_EQ(parse_ids(std::string(64, 'a'), "").request_id, std::string(64, 'a'));
}

TEST(CallIds, DropATraceparentThatIsNone) {
  const std::string good = kTrace;
  for (const std::string& bad :
       {std::string(), good.substr(1), good + "-00", good + "0", "ff" + good.substr(2), "0G" + good.substr(2),
        good.substr(0, 3) + std::string(32, '0') + good.substr(35), good.substr(0, 36) + std::string(16, '0') + "-01",
        "00-0AF7651916CD43DD8448EB211C80319C" + good.substr(35), good.substr(0, 52) + "_01"}) {
    EXPECT_EQ(parse_ids("", bad).trace_id, "") << bad;
    EXPECT_EQ(parse_ids("", bad).parent_id, "") << bad;
  }
  EXPECT_NE(parse_ids("", "01" + good.substr(2) + "-later").trace_id, "");
}

}  // namespace
}  // namespace collided::server
