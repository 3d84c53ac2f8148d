// A program of CLI11, described.

#include "client/cli/manual/describe.hpp"

namespace collided::manual {

namespace {

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> parts;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find(mark, at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

/// Without the brackets of CLI11's lists.
std::string default_of(const CLI::Option& option) {
  const std::string text = option.get_default_str();
  return text.starts_with('[') && text.ends_with(']') ? text.substr(1, text.size() - 2) : text;
}

/// From "INT in [0 - 8]", or "from 0 to 8".
std::string range_of(const std::string& check) {
  constexpr std::string_view kFrom = "from ", kIn = " in [", kTo = " - ";
  if (check.starts_with(kFrom)) return check.substr(kFrom.size());
  const size_t in = check.find(kIn), to = check.rfind(kTo);
  if (in == std::string::npos || to == std::string::npos) return check;
  const size_t min = in + kIn.size(), max = to + kTo.size();
  return check.substr(min, to - min) + " to " + check.substr(max, check.rfind(']') - max);
}

/// CLI11 tells of an option's checks in its type: "TEXT:{ccd,dcd}", "INT:INT in [0 - 8]".
Values values_of(const CLI::Option& option, const KnownWords& known) {
  Values values;
  const std::string text = option.get_type_name();
  const size_t colon = text.find(':');
  values.type = text.substr(0, colon);
  const std::string check = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (check.starts_with('{') && check.ends_with('}'))
    values.choices = split(check.substr(1, check.size() - 2), ',');
  else
    values.range = range_of(check);
  if (const auto words = known.find(values.type); words != known.end()) values.choices = words->second;
  const bool is_switch = option.get_items_expected_min() == 0;
  const bool takes_more = option.get_allow_extra_args();
  values.count = is_switch ? 0 : takes_more ? option.get_items_expected_max() : option.get_type_size_max();
  values.is_list = option.get_delimiter() != '\0';
  return values;
}

std::vector<std::string> names_of(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const CLI::Option* option : options) names.push_back("--" + option->get_lnames().front());
  std::sort(names.begin(), names.end());
  return names;
}

Option described(const CLI::Option& option, const std::string& group, const KnownWords& known) {
  Option out;
  out.description = option.get_description();
  out.values = values_of(option, known);
  out.group = group;
  out.default_value = default_of(option);
  out.variable = option.get_envname();
  out.needs = names_of(option.get_needs());
  out.excludes = names_of(option.get_excludes());
  out.is_required = option.get_required();
  out.is_repeatable = option.get_expected_max() > 1;
  out.is_configurable = option.get_configurable();
  for (const std::string& name : option.get_snames()) out.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) out.names.push_back("--" + name);
  if (out.names.empty()) out.names.push_back(option.get_name(true));
  return out;
}

/// The options of `app`, and of its groups of options, which are subcommands without a name and have --help, too.
void add_options(Command& command, const CLI::App& app, const std::string& group, const KnownWords& known) {
  for (const CLI::Option* option : app.get_options()) {
    const bool is_help_of_group = app.get_name().empty() && option == app.get_help_ptr();
    if (option->get_group().empty() || is_help_of_group) continue;
    auto& list = option->nonpositional() ? command.options : command.arguments;
    list.push_back(described(*option, group, known));
  }
  for (const CLI::App* part : app.get_subcommands([](const CLI::App*) { return true; }))
    if (part->get_name().empty()) add_options(command, *part, part->get_group(), known);
}

std::string usage_of(const CLI::App& app, const std::string& name) {
  const auto formatter = std::dynamic_pointer_cast<CLI::Formatter>(app.get_formatter());
  std::string text = formatter->make_usage(&app, name);
  text.erase(0, text.find(name));
  return text.substr(0, text.find('\n'));
}

Command described(const CLI::App& app, const std::string& full_name, const KnownWords& known) {
  Command command{app.get_name(), app.get_description(), usage_of(app, full_name), app.get_footer(), {}, {}};
  add_options(command, app, "", known);
  return command;
}

}  // namespace

Program describe(const CLI::App& app, const KnownWords& known) {
  Program program;
  program.self = described(app, app.get_name(), known);
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty() && !command->get_group().empty())
      program.commands.push_back(described(*command, app.get_name() + " " + command->get_name(), known));
  return program;
}

}  // namespace collided::manual
