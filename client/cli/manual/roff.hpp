#pragma once
// Text of man pages, in the man(7) macros.

#include <string>

namespace collided::manual {

/// Literal text: hyphens stay hyphens, and nothing begins a request.
std::string escaped(const std::string& text);
std::string bold(const std::string& text);
std::string italic(const std::string& text);

/// A paragraph in short lines, options in bold; ends with a line's end.
std::string paragraph(const std::string& text);
/// ".SH TITLE"
std::string heading(const std::string& title);
std::string subheading(const std::string& title);
/// A tagged paragraph; `tag` is in roff already.
std::string entry(const std::string& tag, const std::string& text);
/// Lines as they are, indented.
std::string example(const std::string& lines);

/// "A sentence" gets its stop, unless it has one.
std::string sentence(const std::string& text);

}  // namespace collided::manual
