// Frames of a scene as they come, as a table on a terminal.

#include "client/cli/live/live_table.hpp"

#include <chrono>
#include <exception>
#include <mutex>
#include <thread>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/output/output.hpp"
#include "client/cli/live/screen.hpp"

namespace collided::cli {

namespace {

constexpr size_t kAllRows = 1000;  // more than there are figures

/// Frames that a thread of its own receives, so that the table can be drawn anew whenever keys or the window ask for
/// it.
class Inbox {
 public:
  Inbox(const v1::SceneSpec& spec, const ReceiveFrame& receive)
      : thread_([this, spec, receive] { run(spec, receive); }) {}

  History history() const {
    const std::lock_guard lock(mutex_);
    return history_;
  }
  bool has_ended() const {
    const std::lock_guard lock(mutex_);
    return has_ended_;
  }
  /// Waits for the end. Throws what ended it early.
  void wait() {
    thread_.join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void run(const v1::SceneSpec& spec, const ReceiveFrame& receive) {
    try {
      while (const auto frame = receive()) {
        const std::lock_guard lock(mutex_);
        history_.add(*frame, spec, History::Clock::now());
      }
    } catch (const std::exception&) {
      failure_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
  }

  mutable std::mutex mutex_;
  History history_;
  bool has_ended_ = false;
  std::exception_ptr failure_;
  std::jthread thread_;
};

struct End {
  bool is_quit;    ///< by the user
  TableSize size;  ///< of the screen
};

End show_until_the_end(const Inbox& inbox, const std::vector<std::string>& title) {
  constexpr std::chrono::milliseconds kPollInterval(50);
  Screen screen;
  uint64_t shown = ~uint64_t{0};
  while (!inbox.has_ended() && !is_interrupted()) {
    const Screen::Key key = screen.key();
    if (key == Screen::Key::kQuit) return {true, screen.size()};
    const History history = inbox.history();
    if (history.frames() != shown || key == Screen::Key::kResized)
      screen.show(table_lines(title, history, screen.size()));
    shown = history.frames();
    if (key == Screen::Key::kNone) std::this_thread::sleep_for(kPollInterval);
  }
  return {false, screen.size()};
}

}  // namespace

void show_live(const v1::Scene& scene, const ReceiveFrame& receive, const std::function<void()>& cancel) {
  const std::vector<std::string> title = table_title(scene);
  Inbox inbox(scene.spec(), receive);
  End end{};
  try {
    end = show_until_the_end(inbox, title);
  } catch (const std::exception&) {
    cancel();
    throw;
  }
  cancel();
  end.size.rows = kAllRows;
  for (const std::string& line : table_lines(title, inbox.history(), end.size)) print_line(line);
  try {
    inbox.wait();
  } catch (const std::exception&) {
    check_interrupt();
    if (!end.is_quit) throw;
  }
}

}  // namespace collided::cli
