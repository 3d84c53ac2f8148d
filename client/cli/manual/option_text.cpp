// An option in a man page.

#include "client/cli/manual/option_text.hpp"

#include <cctype>

#include "client/cli/manual/completion.hpp"
#include "client/cli/manual/roff.hpp"

namespace collided::manual {

namespace {

std::string fact(const std::string& before, const std::string& what) {
  return what.empty() ? "" : " " + before + what + ".";
}

std::string one_of(const Values& values) {
  return (values.is_list ? "One or more, with commas between, of " : "One of ") + joined(values.choices, ", ");
}

bool is_upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

/// "INT", "NAME NAME", "FILE ...".
std::string words_tag(const Values& values) {
  return italic(values.type) + (values.count == Values::kAnyNumber ? " ..." : "");
}

}  // namespace

std::string option_tag(const Option& option) {
  std::string tag;
  for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
  if (option.values.count > 0) return tag + " " + words_tag(option.values);
  return option.values.type.empty() ? tag : tag + "[=" + italic(option.values.type) + "]";
}

std::string key_tag(const Option& option) { return bold(option.name().substr(2)) + " = " + italic(option.values.type); }

std::string option_text(const Option& option) {
  const Values& values = option.values;
  std::string text = sentence(option.description);
  if (option.is_required) text += " Required.";
  if (!values.choices.empty()) text += " " + one_of(values) + ".";
  text += fact("Range: ", values.range) + fact("Default: ", option.default_value);
  text += fact("Needs ", joined(option.needs, " and ")) + fact("Not with ", joined(option.excludes, " or "));
  return text + fact("Variable: ", option.variable);
}

std::string as_phrase(const std::string& text) {
  if (text.size() < 2 || is_upper(text[1])) return text;
  std::string out = text;
  out[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(out[0])));
  return out;
}

}  // namespace collided::manual
