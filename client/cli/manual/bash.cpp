// Completion for bash: tables of the options, and a function that is the same for every program.

#include "client/cli/manual/completion.hpp"

namespace collided::manual {

namespace {

const char* word_of(Offer offer) {
  switch (offer) {
    case Offer::kWords:
      return "words";
    case Offer::kFiles:
      return "files";
    case Offer::kFolders:
      return "folders";
    case Offer::kNothing:
      break;
  }
  return "nothing";
}

/// A line of the table of values: of an option, or of arguments, whose option is empty.
std::string values_line(const std::string& command, const std::string& option, const Values& values) {
  std::string line = "    " + quoted(command + " " + option) + ") offer=" + word_of(offer_of(values)) +
                     " count=" + std::to_string(values.count);
  if (values.is_list) line += " is_list=1";
  if (!values.choices.empty()) line += " words=" + quoted(joined(values.choices));
  return line + " ;;\n";
}

std::string command_lines(const Command& command, const std::string& name) {
  std::string lines;
  for (const Option& option : command.options)
    if (option.values.count > 0)
      for (const std::string& option_name : option.names) lines += values_line(name, option_name, option.values);
  if (!command.arguments.empty()) lines += values_line(name, "", command.arguments.front().values);
  return lines;
}

std::string options_line(const Command& command, const std::string& name) {
  std::string names;
  for (const Option& option : command.options) names += (names.empty() ? "" : " ") + joined(option.names);
  return "    " + quoted(name) + ") words=" + quoted(names) + " ;;\n";
}

Values command_names(const Program& program) {
  Values names;
  for (const Command& command : program.commands) names.choices.push_back(command.name);
  names.count = 1;
  return names;
}

// COMP_WORDS holds "--mode=ccd" as three words if "=" breaks words, as it usually does, else as one.
constexpr auto kFunction = R"(_PROGRAM() {
  local offer count is_list words
  local command='' option='' left=0 prefix='' word
  local -a line=("${COMP_WORDS[@]:1:COMP_CWORD}")
  local cur=${line[-1]-}
  unset 'line[-1]'
  if [[ $cur == = ]]; then
    cur=''
  elif [[ $cur == --*=* ]]; then
    line+=("${cur%%=*}") prefix=${cur%%=*}= cur=${cur#*=}
  fi
  for word in "${line[@]}"; do
    if [[ $word == = ]]; then
      continue
    elif [[ $word == -?* ]]; then
      option=${word%%=*}
      _PROGRAM_values "$command $option"
      left=$count
      if [[ $word == *=* ]]; then left=0; fi
    elif ((left > 0)); then
      ((left -= 1))
    elif [[ -z $command ]]; then
      command=$word
    fi
  done
  if ((left == 0)); then option=''; fi
  _PROGRAM_values "$command $option"
  if [[ $cur == -?* || $cur == - ]] || [[ -z $option && $offer == nothing ]]; then
    offer=words prefix='' is_list=''
    _PROGRAM_options "$command"
  fi
  if [[ -n $is_list && $cur == *,* ]]; then
    prefix+=${cur%,*},
    cur=${cur##*,}
  fi
  COMPREPLY=()
  case $offer in
    words) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur") ;;
    files) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -f -- "$cur") ;;
    folders) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -d -- "$cur") ;;
  esac
  if [[ -n $prefix ]]; then COMPREPLY=("${COMPREPLY[@]/#/$prefix}"); fi
}
complete -F _PROGRAM PROGRAM
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

std::string bash_completion(const Program& program) {
  const std::string& name = program.self.name;
  std::string options = options_line(program.self, ""), values = command_lines(program.self, "");
  if (!program.commands.empty()) values += values_line("", "", command_names(program));
  for (const Command& command : program.commands) {
    options += options_line(command, command.name);
    values += command_lines(command, command.name);
  }
  return "# bash completion of " + name + " " + program.version + ", made from its options.\n\n_" + name +
         "_options() {  # COMMAND\n  case $1 in\n" + options + "    *) words='' ;;\n  esac\n}\n\n_" + name +
         "_values() {  # 'COMMAND OPTION', or 'COMMAND ' for its arguments\n"
         "  offer=nothing count=0 is_list='' words=''\n  case $1 in\n" +
         values + "  esac\n}\n\n" + replaced(kFunction, "PROGRAM", name);
}

}  // namespace collided::manual
