#pragma once
// What a random session is made of: commands, each with numbers that say the rest. All of it shrinks by itself.

#include <rapidcheck.h>

#include <ostream>
#include <vector>

namespace collided::test {

enum class Action {
  kFrame,
  kBurst,
  kBadFrame,
  kEdit,
  kOpen,
  kTakeOver,
  kBreak,
  kClose,
  kCreate,
  kBadCreate,
  kDelete,
  kLook,
  kStranger,
  kBatch,
};

inline const char* name_of(Action action) {
  constexpr const char* kNames[] = {"frame", "burst",  "bad frame",  "edit",   "open", "take over", "break",
                                    "close", "create", "bad create", "delete", "look", "stranger",  "batch"};
  return kNames[static_cast<size_t>(action)];
}

struct Command {
  Action action = Action::kFrame;
  std::vector<int> numbers;
};
using Session = std::vector<Command>;

inline std::ostream& operator<<(std::ostream& out, const Command& command) {
  out << name_of(command.action) << " {";
  for (const int n : command.numbers) out << n << ",";
  return out << "}";
}

/// Reads a command's numbers one after the other, from the start again at their end; 0 is the plainest choice.
class Numbers {
 public:
  explicit Numbers(const Command& command) : all_(command.numbers) {}
  uint32_t below(uint32_t n) {
    if (all_.empty()) return 0;
    const size_t i = next_++;
    return static_cast<uint32_t>(all_[i % all_.size()] + 7 * static_cast<int>(i / all_.size())) % n;
  }
  bool one_in(uint32_t n) { return below(n) == n - 1; }
  /// A small integer, as often negative.
  double coordinate() { return static_cast<double>((below(7) + 3) % 7) - 3; }

 private:
  const std::vector<int>& all_;
  size_t next_ = 0;
};

inline rc::Gen<Session> sessions() {
  using A = Action;
  constexpr int kNumbers = 60, kLargest = 840;  // as many of each remainder
  const auto action = rc::gen::weightedElement<Action>({{10, A::kFrame},
                                                        {3, A::kBurst},
                                                        {4, A::kBadFrame},
                                                        {4, A::kEdit},
                                                        {4, A::kOpen},
                                                        {2, A::kTakeOver},
                                                        {2, A::kBreak},
                                                        {2, A::kClose},
                                                        {1, A::kCreate},
                                                        {1, A::kBadCreate},
                                                        {1, A::kDelete},
                                                        {2, A::kLook},
                                                        {1, A::kStranger},
                                                        {3, A::kBatch}});
  const auto numbers = rc::gen::container<std::vector<int>>(kNumbers, rc::gen::inRange(0, kLargest));
  return rc::gen::container<Session>(rc::gen::construct<Command>(action, numbers));
}

}  // namespace collided::test
