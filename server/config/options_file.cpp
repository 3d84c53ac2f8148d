// The TOML file: its keys are the options without their dashes.
#include <iomanip>
#include <sstream>
#include <toml.hpp>

#include "server/config/options.hpp"
#include "server/config/text_file.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMaxFileBytes = 1 << 20;

// As in a flag or variable.
std::string text_of(const toml::value& value, const std::string& where) {
  if (value.is_string()) return value.as_string().str;
  if (value.is_boolean()) return value.as_boolean() ? "true" : "false";
  if (value.is_integer()) return std::to_string(value.as_integer());
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
  const auto where = path + ":" + std::to_string(value.location().line()) + ": " + key;
  auto* option = app.get_option_no_throw("--" + key);
  if (!option || !option->get_configurable()) throw ConfigError(where + " is not an option");
  const auto texts = texts_of(value, where);
  if (option->count() || texts.empty()) return;
  try {
    for (const auto& text : texts) option->add_result(text);
    option->run_callback();
  } catch (const CLI::Error& error) {
    throw ConfigError(path + ":" + std::to_string(value.location().line()) + ": " + error.what());
  }
}

// With the first line of toml11's message; the others quote the source.
toml::value parse_toml(const std::string& path) try {
  std::istringstream text(read_toml_text(path, kMaxFileBytes));
  return toml::parse(text, path);
} catch (const toml::exception& error) {
  const std::string what = error.what();
  throw ConfigError(path + ":" + std::to_string(error.location().line()) + ": " + what.substr(0, what.find('\n')));
}

}  // namespace

void take_file(CLI::App& app, const std::string& path) {
  for (const auto root = parse_toml(path); const auto& [key, value] : root.as_table())
    set_option(app, path, key, value);
}

}  // namespace collided::server
