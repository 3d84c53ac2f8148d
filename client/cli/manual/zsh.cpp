// Completion for zsh: a call of _arguments for each command.

#include "client/cli/manual/completion.hpp"

namespace collided::manual {

namespace {

/// Inside the brackets or between the colons of _arguments.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::string_view("[]:\\").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string action_of(const Values& values) {
  const std::string words = joined(values.choices);
  switch (offer_of(values)) {
    case Offer::kWords:
      return values.is_list ? "_sequence compadd - " + words : "(" + words + ")";
    case Offer::kFiles:
      return "_files";
    case Offer::kFolders:
      return "_files -/";
    case Offer::kNothing:
      break;
  }
  return " ";
}

/// ":MESSAGE:ACTION" for each word, or once for as many words as come before the next option.
std::string values_spec(const Values& values) {
  const std::string one = ":" + escaped(values.type.empty() ? "word" : values.type) + ":" + action_of(values);
  if (values.count == Values::kAnyNumber) return ":*-*" + one;
  std::string spec;
  for (int i = 0; i < values.count; ++i) spec += (i == 0 ? "" : ":") + one;
  return spec;
}

/// Options that may not follow this one, among them its own other names.
std::string exclusions_of(const Option& option) {
  if (option.name() == "--help" || option.name() == "--version") return "(- *)";
  std::vector<std::string> names = option.excludes;
  if (!option.is_repeatable) names.insert(names.end(), option.names.begin(), option.names.end());
  return names.empty() ? "" : "(" + joined(names) + ")";
}

std::string option_lines(const Option& option) {
  std::string lines;
  for (const std::string& name : option.names) {
    std::string spec = exclusions_of(option) + (option.is_repeatable ? "*" : "") + name;
    if (option.values.count > 0 && name.starts_with("--")) spec += "=";
    spec += "[" + escaped(option.description) + "]" + values_spec(option.values);
    lines += "    " + quoted(spec) + " \\\n";
  }
  return lines;
}

std::string argument_lines(const Command& command) {
  std::string lines;
  for (const Option& argument : command.arguments) {
    const std::string one = ":" + escaped(argument.name()) + ":" + action_of(argument.values);
    if (argument.values.count == Values::kAnyNumber) return lines + "    " + quoted("*" + one) + " \\\n";
    for (int i = 0; i < argument.values.count; ++i)
      lines += "    " + quoted((i == 0 && argument.is_required ? ":" : "::") + one.substr(1)) + " \\\n";
  }
  return lines;
}

std::string function_of(const Command& command, const std::string& name) {
  std::string lines = argument_lines(command);
  for (const Option& option : command.options) lines += option_lines(option);
  return name + "() {\n  _arguments -s -S \\\n" + lines + "    && return 0\n}\n\n";
}

std::string main_function(const Program& program, const std::string& name) {
  std::string text = name + "() {\n  local context state state_descr line\n  typeset -A opt_args\n  _arguments -C \\\n";
  for (const Option& option : program.self.options) text += option_lines(option);
  text +=
      "    '1:command:->command' \\\n    '*:: :->arguments'\n  case $state in\n    command)\n"
      "      local -a commands=(\n";
  for (const Command& command : program.commands)
    text += "        " + quoted(escaped(command.name) + ":" + command.summary) + "\n";
  text += "      )\n      _describe -t commands command commands ;;\n    arguments)\n      case $words[1] in\n";
  for (const Command& command : program.commands)
    text += "        " + command.name + ") " + name + "_" + command.name + " ;;\n";
  return text + "      esac ;;\n  esac\n}\n\n";
}

}  // namespace

std::string zsh_completion(const Program& program) {
  const std::string name = "_" + program.self.name;
  std::string text = "#compdef " + program.self.name + "\n# zsh completion of " + program.self.name + " " +
                     program.version + ", made from its options.\n\n";
  for (const Command& command : program.commands) text += function_of(command, name + "_" + command.name);
  text += program.commands.empty() ? function_of(program.self, name) : main_function(program, name);
  // From a folder of fpath the file is the function's body; a script that is sourced registers it.
  return text + "if [[ ${funcstack[1]-} == " + name + " ]]; then\n  " + name + " \"$@\"\nelse\n  compdef " + name +
         " " + program.self.name + "\nfi\n";
}

}  // namespace collided::manual
