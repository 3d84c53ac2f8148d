// Lines queued for a pipe that nobody reads, and the last lines of a process.
#include "server/ops/line_writer.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <regex>

#include "server/ops/log.hpp"
#include "tests/support/sanitized.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLong(30'000);

class LineWriterTest : public testing::Test {
 protected:
  LineWriterTest() {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    reader_ = ends[0];
    // Neither end is closed: the writer's thread stays.
    writer_ = &LineWriter::make(ends[1], [](uint64_t dropped) { return "dropped " + std::to_string(dropped) + "\n"; });
  }

  /// Reads on until there is such a text.
  void read_until(const std::string& text) {
    while (read_.find(text) == std::string::npos) ASSERT_NO_FATAL_FAILURE(read_more());
  }

  void read_more() {
    char buffer[4096];
    const ssize_t n = read(reader_, buffer, sizeof(buffer));
    ASSERT_GT(n, 0);
    read_.append(buffer, static_cast<size_t>(n));
  }
  /// The number of dropped lines reported in the lines read so far; the writer may have reported some early.
  uint64_t told() const {
    const std::string report = "dropped ";
    uint64_t sum = 0;
    for (size_t at = 0;
         (at = read_.find(report, at)) != std::string::npos && read_.find('\n', at) != std::string::npos;)
      sum += std::stoull(read_.substr(at += report.size(), 20));
    return sum;
  }

  LineWriter* writer_;
  std::string read_;

 private:
  int reader_;
};

TEST_F(LineWriterTest, LinesComeInTheirOrder) {
  std::string all;
  for (int i = 0; i < 100; ++i) {
    const std::string line = "line " + std::to_string(i) + "\n";
    writer_->write(line);
    all += line;
  }
  EXPECT_TRUE(writer_->drain(kLong));
  read_until("line 99\n");
  EXPECT_EQ(read_, all);
  EXPECT_EQ(writer_->dropped(), 0u);
}

TEST_F(LineWriterTest, WhatNobodyTakesIsDroppedCountedAndTold) {
  const std::string line(1023, 'x');
  constexpr uint64_t kLines = 3000;
  for (uint64_t i = 0; i < kLines; ++i) writer_->write(line + "\n");
  const uint64_t dropped = writer_->dropped();
  EXPECT_GT(dropped, kLines / 2);
  EXPECT_LT(dropped, kLines);
  EXPECT_FALSE(writer_->drain(milliseconds(1)));
  while (told() < dropped) ASSERT_NO_FATAL_FAILURE(read_more());
  EXPECT_EQ(told(), dropped);
  for (uint64_t i = 0; i < 10; ++i) writer_->write("more\n");
  read_until("more\nmore\n");
  EXPECT_EQ(writer_->dropped(), dropped);
}

TEST(LastLines, AreWrittenAtACrash) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto crash = [](auto&& die) {
    set_up_log("text", "info");
    flush_log_at_crash();
    for (int i = 0; i < 100; ++i) spdlog::info("line {}.", i);
    die();
  };
  EXPECT_EXIT(crash([] { std::abort(); }), testing::KilledBySignal(SIGABRT), "line 99\\.");
  if (!test::kIsSanitized) {  // which has a handler of its own, and exits
    EXPECT_EXIT(crash([] { raise(SIGSEGV); }), testing::KilledBySignal(SIGSEGV), "line 99\\.");
  }
  EXPECT_EXIT(crash([] { std::terminate(); }), testing::KilledBySignal(SIGABRT), "line 99\\.");
  EXPECT_EXIT(crash([] { std::exit(3); }), testing::ExitedWithCode(3), "line 99\\.");
}

}  // namespace
}  // namespace collided::server
