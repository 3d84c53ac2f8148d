// The TOML file: its keys are the options without their dashes.
#include <cstdint>
#include <iomanip>
#include <limits>
#include <sstream>

#include "server/config/file/text_file.hpp"
#include "server/config/file/toml_value.hpp"
#include "server/config/options.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFileBytes = 1 << 20;

// toml11 reads what 64 bits don't hold as the nearest that they do.
std::string text_of_integer(int64_t value, const std::string& where) {
  using Bounds = std::numeric_limits<int64_t>;
  constexpr auto kBeyond = ", which is beyond the limits of all options";
  if (value == Bounds::max()) throw ConfigError(where + " is " + std::to_string(value) + " or more" + kBeyond);
  if (value == Bounds::min()) throw ConfigError(where + " is " + std::to_string(value) + " or less" + kBeyond);
  return std::to_string(value);
}

// As in a flag or variable.
std::string text_of(const toml::value& value, const std::string& where) {
  if (value.is_string()) return text_in(value);
  if (value.is_boolean()) return value.as_boolean() ? "true" : "false";
  if (value.is_integer()) return text_of_integer(value.as_integer(), where);
  if (!value.is_floating()) throw ConfigError(where + " is neither a string nor a number nor a boolean");
  std::ostringstream text;
  text << std::setprecision(17) << value.as_floating();
  return text.str();
}

std::vector<std::string> texts_of(const toml::value& value, const std::string& where) {
  std::vector<std::string> texts;
  if (value.is_array()) {
    for (const auto& element : value.as_array()) texts.push_back(text_of(element, where));
  } else {
    texts.push_back(text_of(value, where));
  }
  std::erase(texts, "");  // an empty value leaves the option unset, as for a variable
  return texts;
}

void set_option(CLI::App& app, const std::string& path, const std::string& key, const toml::value& value) {
  const auto where = path + ":" + std::to_string(line_of(value)) + ": " + key;
  auto* option = app.get_option_no_throw("--" + key);
  if (!option || !option->get_configurable()) throw ConfigError(where + " is not an option");
  const auto texts = texts_of(value, where);
  if (option->count() || texts.empty()) return;
  try {
    for (const auto& text : texts) option->add_result(text);
    option->run_callback();
  } catch (const CLI::Error& error) {
    throw ConfigError(path + ":" + std::to_string(line_of(value)) + ": " + error.what());
  }
}

// With the first line of toml11's message; the others quote the source.
toml::value parse_toml(const std::string& path) try {
  std::istringstream text(read_toml_text(path, kMaxFileBytes));
  return toml::parse(text, path);
} catch (const TomlError& error) {
  const std::string what = error.what();
  throw ConfigError(path + ":" + std::to_string(line_of(error)) + ": " + what.substr(0, what.find('\n')));
}

}  // namespace

void take_file(CLI::App& app, const std::string& path) {
  for (const auto root = parse_toml(path); const auto& [key, value] : root.as_table())
    set_option(app, path, key, value);
}

}  // namespace collided::server
