#pragma once
// A terminal's whole screen, by ncurses. One at a time.

#include <string>
#include <vector>

#include "client/cli/live/table.hpp"

namespace collided::cli {

/// Takes the screen and gives it back as it was, also when an interrupt ends collidectl. Interrupts are deferred
/// (daemon/interrupt.hpp) before one is made.
class Screen {
 public:
  /// Throws std::runtime_error if TERM is not a terminal with a screen.
  Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;
  ~Screen();

  TableSize size() const;
  void show(const std::vector<std::string>& text);
  enum class Key { kNone, kQuit, kResized, kOther };
  /// What was typed or happened since the last call; returns at once.
  Key key();

 private:
  void* screen_;
};

/// Whether standard output is a terminal that a Screen can take.
bool has_screen();

}  // namespace collided::cli
