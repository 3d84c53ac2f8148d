// Error messages for bad command lines, with suggestions.

#include "client/app/options/usage.hpp"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>

#include "deploy/help/help.hpp"

namespace collided::cli {

namespace {

/// The subcommand that was given, or collidectl itself.
const CLI::App& command_of(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : *given.front();
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); }))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string suggestion(const std::string& meant, const std::string& otherwise) {
  return meant.empty() ? "; " + otherwise : "; did you mean " + meant + "?";
}

std::string unknown_word(const CLI::App& app, const std::string& word) {
  const CLI::App& command = command_of(app);
  const bool is_option = word.starts_with("-") && word.size() > 1;
  const bool is_command = &command == &app && !is_option;
  if (is_command)
    return "'" + word + "' is not a command" +
           suggestion(nearest(word, command_names(app)), "there are " + joined(command_names(app)));
  const std::string of = &command == &app ? "collidectl" : "'" + command.get_name() + "'";
  const std::string help = "collidectl " + (&command == &app ? "" : command.get_name() + " ") + "--help";
  const std::string option = word.substr(0, word.find('='));
  if (!is_option) return "'" + word + "' is one word too many for " + of + "; see '" + help + "'";
  return option + " is not an option of " + of +
         suggestion(nearest(option, option_names(command)), "see '" + help + "'");
}

/// CLI11's "--out: 1 required FILE missing".
std::string missing_value(const std::string& text) {
  const std::string required = " required ", missing = " missing";
  const size_t colon = text.find(": "), at = text.find(required);
  if (colon == std::string::npos || at == std::string::npos || colon > at || !text.ends_with(missing)) return text;
  const size_t type = at + required.size();
  const std::string count = text.substr(colon + 2, at - colon - 2);
  return text.substr(0, colon) + " needs " + count + (count == "1" ? " value, " : " values, ") +
         text.substr(type, text.size() - missing.size() - type);
}

/// Without the leading dashes, which would make all options look alike.
std::string letters_of(const std::string& word) {
  const auto first = word.find_first_not_of('-');
  return first == std::string::npos ? "" : word.substr(first);
}

class UsageFormatter : public FittedFormatter {
 public:
  std::string make_option_usage(const CLI::Option* option) const override {
    const std::string name = make_option_name(option, true);
    if (option->get_expected_max() == CLI::detail::expected_max_vector_size) return "[" + name + "...]";
    std::string usage = name;
    for (int i = 1; i < option->get_expected_max(); ++i)
      usage += i < option->get_expected_min() ? " " + name : " [" + name + "]";
    return option->get_required() ? usage : "[" + usage + "]";
  }
};

}  // namespace

size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  size_t best_distance = (letters_of(word).size() + 1) / 3 + 1;  // one letter in three may be wrong
  for (const std::string& candidate : known)
    if (const size_t distance = edit_distance(letters_of(word), letters_of(candidate)); distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  return best;
}

void refuse_empty_values(CLI::App& app) {
  const CLI::Validator check([](const std::string& word) { return word.empty() ? "the value is empty" : ""; }, "");
  for (CLI::Option* option : app.get_options())
    if (option->get_items_expected_max() > 0) option->transform(check);  // goes before the option's own checks
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) refuse_empty_values(*command);
}

std::string without_controls(const std::string& text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f)
      out += c;
    else
      (out += "\\x") += {kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return out;
}

std::string usage_message(const CLI::App& app, const CLI::Error& error) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (!unknown.empty()) return unknown_word(app, unknown.front());
  if (command_of(app).get_name() == app.get_name())
    return "a command is needed: " + joined(command_names(app)) + "; see 'collidectl --help'";
  return missing_value(error.what());
}

std::shared_ptr<CLI::FormatterBase> usage_formatter() {
  auto formatter = std::make_shared<UsageFormatter>();
  formatter->label("SUBCOMMAND", "COMMAND");
  return formatter;
}

}  // namespace collided::cli
