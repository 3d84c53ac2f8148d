// A terminal's whole screen, by ncurses.

#include "client/cli/live/screen.hpp"

#define NCURSES_NOMACROS
#include <langinfo.h>
#include <ncurses.h>
#include <term.h>
#include <termios.h>
#include <unistd.h>

#include <clocale>
#include <cstring>
#include <stdexcept>
#include <tuple>

#include "client/app/daemon/interrupt.hpp"

namespace collided::cli {

namespace {

// What gives the terminal back, prepared for a signal handler.
termios before;
std::string goodbye;

void restore() {
  std::ignore = write(STDOUT_FILENO, goodbye.data(), goodbye.size());
  tcsetattr(STDIN_FILENO, TCSANOW, &before);
}

bool is_unicode() { return std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0; }

/// Of the terminal's description; empty if it cannot do that.
std::string capability(const char* name) {
  const char* const text = tigetstr(name);
  return text == nullptr || text == reinterpret_cast<const char*>(-1) ? "" : text;
}

}  // namespace

bool has_screen() {
  int error = 0;
  return isatty(STDOUT_FILENO) != 0 && setupterm(nullptr, STDOUT_FILENO, &error) == OK && !capability("cup").empty();
}

Screen::Screen() {
  std::setlocale(LC_CTYPE, "");  // for curves; numbers stay as they are
  tcgetattr(STDIN_FILENO, &before);
  screen_ = has_screen() ? newterm(nullptr, stdout, stdin) : nullptr;
  if (screen_ == nullptr) {
    const char* const term = std::getenv("TERM");
    throw std::runtime_error(std::string("the terminal, TERM=") + (term ? term : "") + ", has no screen for a table");
  }
  goodbye = capability("sgr0") + capability("rmcup") + capability("cnorm");
  restore_on_forced_end(restore);
  cbreak();
  noecho();
  nodelay(stdscr, TRUE);
  keypad(stdscr, TRUE);
  curs_set(0);
}

Screen::~Screen() {
  endwin();
  delscreen(static_cast<SCREEN*>(screen_));
  restore_on_forced_end(nullptr);
}

TableSize Screen::size() const {
  return {static_cast<size_t>(getmaxx(stdscr)), static_cast<size_t>(getmaxy(stdscr)), is_unicode()};
}

void Screen::show(const std::vector<std::string>& text) {
  werase(stdscr);
  for (size_t row = 0; row < text.size(); ++row)
    mvwaddnstr(stdscr, static_cast<int>(row), 0, text[row].data(), static_cast<int>(text[row].size()));
  wrefresh(stdscr);
}

Screen::Key Screen::key() {
  switch (const int typed = wgetch(stdscr)) {
    case ERR:
      return Key::kNone;
    case KEY_RESIZE:
      return Key::kResized;
    default:
      return typed == 'q' || typed == 'Q' ? Key::kQuit : Key::kOther;
  }
}

}  // namespace collided::cli
