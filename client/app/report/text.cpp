// Reports for people.

#include "client/app/report/text.hpp"

#include <algorithm>

#include "client/app/report/numbers.hpp"

namespace collided::cli {

namespace {

constexpr std::string_view kMilliseconds = "_ms";

bool is_milliseconds(const std::string& name) { return name.ends_with(kMilliseconds); }

/// Without the unit, which goes to the value.
std::string label_of(const std::string& name) {
  return is_milliseconds(name) ? name.substr(0, name.size() - kMilliseconds.size()) : name;
}

std::string joined(const Json& array) {
  std::string text;
  for (const Json& value : array)
    text += (text.empty() ? "" : ", ") + (value.is_string() ? value.get<std::string>() : value.dump());
  return text.empty() ? "none" : text;
}

std::string number_text(const std::string& name, const Json& value) {
  if (name == "delta" && value == 0) return "automatic";
  if (value.is_number_integer()) {
    const bool is_bytes = name.find("bytes") != std::string::npos;
    return count_text(value.get<uint64_t>()) + (is_bytes ? " bytes" : "");
  }
  return format_double("%.4g", value.get<double>()) + (name == "seconds" ? " s" : "");
}

std::string value_text(const std::string& name, const Json& value) {
  if (value.is_null()) return "not counted";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_array()) return joined(value);
  if (value.is_number()) return number_text(name, value);
  const std::string text = value.get<std::string>();
  return text.empty() ? "none" : text;
}

std::string line(const std::string& label, size_t width, const std::string& value) {
  return label + std::string(width - label.size() + 2, ' ') + value + "\n";
}

/// Times of stages by name.
std::string times_text(const Json& times, size_t indent) {
  size_t width = 0;
  for (const auto& [name, ms] : times.items()) width = std::max(width, name.size());
  std::string out;
  for (const auto& [name, ms] : times.items())
    out += std::string(indent, ' ') + line(name, width, milliseconds_text(ms.get<double>()) + " ms");
  return out;
}

}  // namespace

std::string report_text(const Json& object, size_t indent) {
  size_t width = 0;
  for (const auto& [name, value] : object.items())
    if (!value.is_object()) width = std::max(width, label_of(name).size());
  std::string out;
  const std::string margin(indent, ' ');
  for (const auto& [name, value] : object.items()) {
    const std::string label = shown_name(label_of(name));  // a mesh's name may be a label
    if (value.is_object())
      out += margin + label +
             (is_milliseconds(name) ? "s\n" + times_text(value, indent + 2) : "\n" + report_text(value, indent + 2));
    else if (is_milliseconds(name))
      out += margin + line(label, width, milliseconds_text(value.get<double>()) + " ms");
    else
      out += margin + line(label, width, value_text(name, value));
  }
  return out;
}

std::string shown_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c >= 0x7f; }, '?');
  return name;
}

}  // namespace collided::cli
