// Each failpoint fails once in each stage of a stream's life. The daemon lives, the client has the right answer or is
// told why not, the stage succeeds when asked for again, and all frames have the contacts of an undisturbed life. What
// clients saw is TABLE.md; COLLIDED_WRITE_FAULT_TABLE=FILE writes it anew.
#include <gtest/gtest.h>
#include <string.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/integration/faults/control.hpp"
#include "tests/integration/faults/life.hpp"

namespace collided::test {
namespace {

struct Failpoint {
  std::string symbol, error;
  std::string name() const { return (symbol.starts_with("_ZNSt6thread") ? "std::thread" : symbol) + " " + error; }
};

int number_of(const std::string& error) {
  if (isdigit(error[0])) return std::stoi(error);
  for (int i = 1; i < 200; ++i)
    if (const char* const name = strerrorname_np(i); name && error == name) return i;
  throw std::runtime_error("no such error: " + error);
}

std::vector<Failpoint> failpoints() {
  std::vector<Failpoint> all;
  std::ifstream file(COLLIDED_FAILPOINTS);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string symbol, error;
    words >> symbol;
    if (symbol.empty() || symbol[0] == '#') continue;
    if (symbol.find("cuda") != std::string::npos && test_backend() != "cuda") continue;
    while (words >> error && error != ":") all.push_back({symbol, error});
    if (error == ":") continue;
  }
  return all;
}

/// Outcomes by failpoint and stage.
using Table = std::map<std::string, std::vector<std::string>>;

class Faults : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    setenv("COLLIDED_DAEMON", setting("COLLIDED_FAULTY", COLLIDED_FAULTY_DAEMON).c_str(), 1);
    control_file() = (std::filesystem::temp_directory_path() / ("collided-faults-" + std::to_string(getpid()))).string();
    setenv(kControlVariable, control_file().c_str(), 1);
    control() = map_control(control_file().c_str());
    ASSERT_NE(control(), nullptr);
  }
  static void TearDownTestSuite() { std::filesystem::remove(control_file()); }

  static std::string& control_file() {
    static std::string file;
    return file;
  }
  static FaultControl*& control() {
    static FaultControl* control = nullptr;
    return control;
  }

  static void arm(const Failpoint& failpoint, bool lasts = false) {
    FaultControl& now = *control();
    now.calls_left = 0;
    now.failed = 0;
    now.lasts = lasts;
    now.error = number_of(failpoint.error);
    failpoint.symbol.copy(now.symbol, sizeof(now.symbol) - 1);
    now.symbol[failpoint.symbol.size()] = '\0';
    now.calls_left = 1;
  }
  /// Whether it has failed.
  static bool disarm() {
    control()->calls_left = 0;
    return control()->failed > 0;
  }

  /// A connection that has failed cannot say why.
  static bool is_clear(const Failpoint& failpoint, const Outcome& outcome) {
    if (failpoint.error == "EPIPE" && outcome.code == "HUNG UP") return true;
    static const std::set<std::string> unclear{"HUNG UP", "ENDED", "WRONG", "SKIPPED", "DEADLINE_EXCEEDED", "UNKNOWN"};
    return !unclear.contains(outcome.code) && (outcome.ok() || !outcome.message.empty());
  }
};

/// One life with a failure in each stage.
std::vector<std::string> live(Life& life, const std::function<void()>& arm, const std::function<bool()>& disarm,
                              const std::function<bool(const Outcome&)>& is_clear) {
  std::vector<std::string> cells;
  for (const auto& [name, run] : Life::stages()) {
    SCOPED_TRACE(name);
    arm();
    const Outcome outcome = (life.*run)();
    const bool failed = disarm();
    cells.push_back(failed ? outcome.code : outcome.ok() ? "" : "NOT FAILED: " + outcome.code);
    EXPECT_TRUE(is_clear(outcome)) << outcome.code << ": " << outcome.message;
    if (std::getenv("COLLIDED_TELL_FAULTS") && !outcome.ok())
      std::printf("  %s: %s: %s\n", name, outcome.code.c_str(), outcome.message.c_str());
    if (outcome.ok()) continue;
    const Outcome again = (life.*run)();
    EXPECT_TRUE(again.ok()) << "asked again: " << again.code << ": " << again.message;
  }
  return cells;
}

TEST_F(Faults, EachInEachStageIsAnsweredOrTold) {
  LocalDaemon daemon;
  for (const Transport transport : {Transport::kGrpc, Transport::kLocal}) {
    std::map<uint64_t, std::string> contacts;
    {
      Life undisturbed(daemon, transport, contacts);
      for (const auto& cell : live(undisturbed, [] {}, [] { return false; }, [](const Outcome& outcome) { return outcome.ok(); })) EXPECT_EQ(cell, "");
    }
    for (const Failpoint& failpoint : failpoints()) {
      SCOPED_TRACE(failpoint.name() + (transport == Transport::kGrpc ? ", gRPC" : ", local socket"));
      if (std::getenv("COLLIDED_TELL_FAULTS")) std::printf("%s %d\n", failpoint.name().c_str(), int(transport));
      Life life(daemon, transport, contacts);
      const auto cells = live(life, [&] { arm(failpoint); }, disarm, [&](const Outcome& outcome) { return is_clear(failpoint, outcome); });
      std::string line = failpoint.name() + ":";
      for (const auto& cell : cells) line += " | " + cell;
      if (std::getenv("COLLIDED_TELL_FAULTS")) std::puts(line.c_str());
      ASSERT_EQ(waitpid(daemon.process().pid(), nullptr, WNOHANG), 0) << "the daemon has died";
    }
  }
  daemon.expect_good_streams();
}

}  // namespace
}  // namespace collided::test
