// Each failpoint fails once in each stage of a stream's life. The daemon lives, the client has the right answer or is
// told why not, the stage succeeds when asked for again, and all frames have the contacts of an undisturbed life. What
// clients saw is TABLE.md; COLLIDED_WRITE_FAULT_TABLE=FILE writes it anew.
#include <gtest/gtest.h>
#include <string.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <iostream>
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
  std::ifstream file(setting("COLLIDED_FAILPOINTS", COLLIDED_FAILPOINTS));
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string symbol, error;
    words >> symbol;
    if (symbol.empty() || symbol[0] == '#') continue;
    if (symbol.find("cuda") != std::string::npos && test_backend() != "cuda") continue;
    while (words >> error && error != ":") all.push_back({symbol, error});
  }
  if (all.empty()) throw std::runtime_error("no failpoints");
  return all;
}

/// What clients saw, a line for each transport and failpoint, with a cell for each stage.
using Lines = std::vector<std::vector<std::string>>;

Lines read_table() {
  Lines lines;
  std::ifstream file(COLLIDED_FAULT_TABLE);
  for (std::string text; std::getline(file, text);) {
    if (!text.starts_with("| gRPC") && !text.starts_with("| local")) continue;
    std::vector<std::string>& cells = lines.emplace_back();
    for (size_t begin = 2, end = 0; (end = text.find(" |", begin - 1)) != std::string::npos; begin = end + 3)
      cells.push_back(begin < end ? text.substr(begin, end - begin) : "");
  }
  return lines;
}

void write_table(const Lines& lines, const char* path) {
  std::ofstream file(path);
  file << "# What clients see\n\n"
          "Each call of the system or of CUDA that fails once in each stage of a stream's life: *right*: nothing, the "
          "answer is right; a code:\nthe stage is refused with it and a reason, and succeeds when asked for again; "
          "HUNG UP: the connection ends, as it has failed; empty: the stage\ndoes not get there. Written by "
          "integration_faults_test (COLLIDED_WRITE_FAULT_TABLE=FILE), which compares with it.\n\n| | failpoint |";
  for (const auto& stage : Life::stages()) file << ' ' << stage.name << " |";
  file << "\n| --- | --- |";
  for (size_t i = 0; i < Life::stages().size(); ++i) file << " --- |";
  for (const auto& line : lines) {
    file << "\n|";
    for (const auto& cell : line) file << ' ' << cell << " |";
  }
  file << '\n';
}

/// Which thread comes first is chance: a failure may hit one that no client waits for, and an allocation may find kept
/// memory. Where no connection could be accepted, an idle one is ended for it, which may be that of this client.
bool is_same(const std::vector<std::string>& known, const std::string& seen, const std::string& cell) {
  const std::string& failpoint = known[1];
  const bool is_memory = failpoint.ends_with(" ENOMEM") && std::find(known.begin(), known.end(), seen) != known.end();
  const auto may_be_unseen = [&](const std::string& what) {
    return what.empty() || what == "right" || (what == "UNAVAILABLE" && failpoint.starts_with("accept4 ")) ||
           (what == "RESOURCE_EXHAUSTED" && is_memory);
  };
  return seen == cell || (may_be_unseen(seen) && may_be_unseen(cell));
}

class Faults : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    setenv("COLLIDED_DAEMON", setting("COLLIDED_FAULTY", COLLIDED_FAULTY_DAEMON).c_str(), 1);
    control_file() =
        (std::filesystem::temp_directory_path() / ("collided-faults-" + std::to_string(getpid()))).string();
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

  static void arm(const Failpoint& failpoint, int call, bool lasts = false) {
    FaultControl& now = *control();
    now.calls_left = 0;
    now.failed = 0;
    now.lasts = lasts;
    now.error = number_of(failpoint.error);
    failpoint.symbol.copy(now.symbol, sizeof(now.symbol) - 1);
    now.symbol[failpoint.symbol.size()] = '\0';
    now.calls_left = call;
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

using Armed = std::function<void()>;

/// One life with a failure in each stage; what the client saw.
std::vector<std::string> live(Life& life, const Armed& arm, const std::function<bool()>& disarm,
                              const std::function<bool(const Outcome&)>& is_clear) {
  std::vector<std::string> cells;
  bool has_failed = false;
  for (const auto& [name, run] : Life::stages()) {
    SCOPED_TRACE(name);
    arm();
    const Outcome outcome = (life.*run)();
    const bool failed = disarm();
    EXPECT_TRUE(is_clear(outcome)) << outcome.code << ": " << outcome.message;
    has_failed = has_failed || failed;  // a late call may be noticed by the next stage
    EXPECT_TRUE(has_failed || outcome.ok()) << "without a failure: " << outcome.code << ": " << outcome.message;
    cells.push_back(!failed ? "" : outcome.ok() ? "right" : outcome.code);
    if (outcome.ok()) continue;
    const Outcome again = (life.*run)();
    EXPECT_TRUE(again.ok()) << "asked again: " << again.code << ": " << again.message;
  }
  return cells;
}

const char* name_of(Transport transport) { return transport == Transport::kGrpc ? "gRPC" : "local"; }

class Lives : public Faults {
 protected:
  /// The lines of all failpoints, each of which fails at the `call`th call.
  Lines live_with_each(Transport transport, int call) {
    Lines lines;
    live_undisturbed(transport);
    for (const Failpoint& failpoint : failpoints()) {
      lines.push_back(live_with(failpoint, transport, call));
      if (HasFailure() || waitpid(daemon_.process().pid(), nullptr, WNOHANG) != 0) {
        ADD_FAILURE() << "the daemon has died, or the rest would only repeat what failed";
        break;
      }
    }
    return lines;
  }

  void live_undisturbed(Transport transport) {
    contacts_.clear();
    Life undisturbed(daemon_, transport, contacts_);
    live(
        undisturbed, [] {}, [] { return false; }, [](const Outcome& outcome) { return outcome.ok(); });
  }

  std::vector<std::string> live_with(const Failpoint& failpoint, Transport transport, int call) {
    SCOPED_TRACE(std::string(name_of(transport)) + ", " + failpoint.name());
    Life life(daemon_, transport, contacts_);
    auto cells = live(
        life, [&] { arm(failpoint, call); }, disarm,
        [&](const Outcome& outcome) { return is_clear(failpoint, outcome); });
    cells.insert(cells.begin(), {name_of(transport), failpoint.name()});
    return cells;
  }

  /// The number of the first cell that is not as expected; that of cells where all are.
  static size_t first_difference(const std::vector<std::string>& seen, const std::vector<std::string>& expected) {
    size_t k = 0;
    while (k < seen.size() && k < expected.size() && is_same(expected, seen[k], expected[k])) ++k;
    return k;
  }

  /// The failure may have hit a thread that no client waits for, so that the stage did not meet it: some of a few lives
  /// has what the table says.
  void expect_line(const Failpoint& failpoint, Transport transport, std::vector<std::string> seen,
                   const std::vector<std::string>& expected) {
    ASSERT_EQ(seen.size(), expected.size()) << failpoint.name();
    constexpr int kLives = 4;
    size_t k = first_difference(seen, expected);
    for (int lives = 1; k < expected.size() && lives < kLives && !HasFailure(); ++lives) {
      std::cout << "lived again: " << seen[0] << ", " << seen[1] << ", column " << k << ": " << seen[k] << " instead of "
                << expected[k] << std::endl;
      live_undisturbed(transport);
      seen = live_with(failpoint, transport, 1);
      k = first_difference(seen, expected);
    }
    if (k < expected.size())
      ADD_FAILURE() << seen[0] << ", " << seen[1] << ", column " << k << ": " << seen[k] << " instead of " << expected[k]
                    << " in " << kLives << " lives";
  }

  std::map<uint64_t, std::string> contacts_;
  LocalDaemon daemon_;
};

TEST_F(Lives, WithEachFailureInEachStageAreThoseOfTheTable) {
  Lines seen = live_with_each(Transport::kGrpc, 1);
  for (auto& line : live_with_each(Transport::kLocal, 1)) seen.push_back(std::move(line));
  daemon_.expect_good_streams();
  if (const char* const path = std::getenv("COLLIDED_WRITE_FAULT_TABLE")) write_table(seen, path);
  if (test_backend() != "cpu" || HasFailure()) return;  // the table is that of CPU cores
  const Lines expected = read_table();
  ASSERT_EQ(seen.size(), expected.size());
  const std::vector<Failpoint> all = failpoints();
  for (size_t i = 0; i < seen.size(); ++i)
    expect_line(all[i % all.size()], i < all.size() ? Transport::kGrpc : Transport::kLocal, seen[i], expected[i]);
}

// COLLIDED_FAULT_CALLS=N: at the later calls of each stage, too, up to the Nth.
TEST_F(Lives, GoOnWhicheverCallFails) {
  const int calls = std::stoi(setting("COLLIDED_FAULT_CALLS", "2"));
  for (int call = 2; call <= calls; ++call) {
    SCOPED_TRACE("call " + std::to_string(call));
    live_with_each(Transport::kGrpc, call);
    live_with_each(Transport::kLocal, call);
    if (HasFailure()) return;
  }
  daemon_.expect_good_streams();
}

}  // namespace
}  // namespace collided::test
