// Completion for fish: a line for each option.

#include <algorithm>

#include "client/cli/manual/completion.hpp"

namespace collided::manual {

namespace {

std::string fish_quoted(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') out += '\\';
    out += c;
  }
  return quoted(out, "\\'");
}

/// -r: a word must follow; -x: and no file.
std::string values_flags(const Values& values) {
  if (values.count == 0) return "";
  const std::string words = joined(values.choices);
  switch (offer_of(values)) {
    case Offer::kWords:
      if (values.is_list) return " -x -a " + fish_quoted("(__fish_complete_list , 'printf %s\\n " + words + "')");
      return " -x -a " + fish_quoted(words);
    case Offer::kFiles:
      return " -r -F";
    case Offer::kFolders:
      return " -x -a '(__fish_complete_directories)'";
    case Offer::kNothing:
      break;
  }
  return " -x";
}

std::string option_line(const std::string& begin, const Option& option) {
  std::string line = begin;
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return line + values_flags(option.values) + " -d " + fish_quoted(option.description) + "\n";
}

/// Words without an option: of arguments, or the further ones of an option that takes as many as come.
std::string argument_lines(const std::string& begin, const Command& command) {
  std::vector<Option> taking = command.arguments;
  std::copy_if(command.options.begin(), command.options.end(), std::back_inserter(taking),
               [](const Option& option) { return option.values.count > 1 && !option.values.is_list; });
  std::string lines;
  for (const Option& one : taking) {
    const Offer offer = offer_of(one.values);
    if (offer == Offer::kFiles && lines.find(" -F\n") == std::string::npos) lines += begin + " -F\n";
    if (offer == Offer::kWords) lines += begin + " -a " + fish_quoted(joined(one.values.choices)) + "\n";
  }
  return lines;
}

}  // namespace

std::string fish_completion(const Program& program) {
  const std::string& name = program.self.name;
  std::string text = "# fish completion of " + name + " " + program.version + ", made from its options.\n\n";
  const std::string all = "complete -c " + name;
  text += all + " -f\n";  // no files but where an option takes them
  const std::string first = program.commands.empty() ? all : all + " -n __fish_use_subcommand";
  for (const Option& option : program.self.options) text += option_line(first, option);
  text += argument_lines(first, program.self);
  for (const Command& command : program.commands) {
    text += first + " -a " + command.name + " -d " + fish_quoted(command.summary) + "\n";
    const std::string begin = all + " -n '__fish_seen_subcommand_from " + command.name + "'";
    for (const Option& option : command.options) text += option_line(begin, option);
    text += argument_lines(begin, command);
  }
  return text;
}

}  // namespace collided::manual
