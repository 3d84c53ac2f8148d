// Text of man pages, in the man(7) macros.

#include "client/cli/manual/roff.hpp"

#include <cctype>
#include <sstream>
#include <string_view>

namespace collided::manual {

namespace {

constexpr size_t kLineLength = 78;

/// A line that begins with one of these would be a request.
std::string as_text_line(const std::string& line) {
  return line.starts_with('.') || line.starts_with('\'') ? "\\&" + line : line;
}

bool is_option_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-'; }

/// Bold as far as it is an option: "--find-max," without its comma.
std::string marked(const std::string& word) {
  if (!word.starts_with("--") || word.size() < 3) return escaped(word);
  size_t end = 2;
  while (end < word.size() && is_option_letter(word[end])) ++end;
  return bold(word.substr(0, end)) + escaped(word.substr(end));
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'')
      out += "\\(aq";
    else if (c == '`')
      out += "\\(ga";
    else
      out += c;
  }
  return out;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string paragraph(const std::string& text) {
  std::istringstream words(text);
  std::string out, line;
  for (std::string word; words >> word;) {
    const std::string next = marked(word);
    if (!line.empty() && line.size() + 1 + next.size() > kLineLength) {
      out += as_text_line(line) + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + next;
    // A sentence ends with its line, so that formatters know it from an abbreviation.
    if (word.ends_with('.') || word.ends_with('?')) {
      out += as_text_line(line) + "\n";
      line.clear();
    }
  }
  return line.empty() ? out : out + as_text_line(line) + "\n";
}

std::string heading(const std::string& title) { return ".SH " + title + "\n"; }
std::string subheading(const std::string& title) { return ".SS " + title + "\n"; }
std::string entry(const std::string& tag, const std::string& text) { return ".TP\n" + tag + "\n" + paragraph(text); }

std::string example(const std::string& lines) {
  std::istringstream in(lines);
  std::string out = ".RS 4\n.nf\n";
  for (std::string line; std::getline(in, line);) {
    const size_t first = line.find_first_not_of(' ');
    if (first != std::string::npos) out += as_text_line(escaped(line.substr(first))) + "\n";
  }
  return out + ".fi\n.RE\n";
}

std::string sentence(const std::string& text) {
  if (text.empty()) return text;
  const bool is_ended = std::string_view(".?!:").find(text.back()) != std::string_view::npos;
  return is_ended ? text : text + ".";
}

}  // namespace collided::manual
