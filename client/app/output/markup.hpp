#pragma once
// Text in XML and HTML.

#include <string>

namespace collided::cli {

/// With the characters replaced that mean something there, also in the value of an attribute.
inline std::string escape_markup(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

}  // namespace collided::cli
