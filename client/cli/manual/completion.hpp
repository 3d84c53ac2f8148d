#pragma once
// Scripts that teach shells to complete a program's commands, options and their words.

#include <string>
#include <vector>

#include "client/cli/manual/program.hpp"

namespace collided::manual {

std::string bash_completion(const Program& program);
std::string zsh_completion(const Program& program);
std::string fish_completion(const Program& program);

/// What a shell offers where a value is expected.
enum class Offer { kNothing, kWords, kFiles, kFolders };
inline Offer offer_of(const Values& values) {
  if (!values.choices.empty()) return Offer::kWords;
  if (values.type == "FOLDER") return Offer::kFolders;
  return values.type == "FILE" || values.type == "TEXT" ? Offer::kFiles : Offer::kNothing;
}

/// A word in single quotes; `escape` stands for a quotation mark inside them.
inline std::string quoted(const std::string& word, const std::string& escape = "'\\''") {
  std::string out = "'";
  for (const char c : word) c == '\'' ? out += escape : out += c;
  return out + "'";
}

inline std::string joined(const std::vector<std::string>& words, const std::string& between = " ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

}  // namespace collided::manual
