#pragma once
// An option in a man page.

#include <string>

#include "client/cli/manual/program.hpp"

namespace collided::manual {

/// "-h, --help", "--mode TEXT", "--cuda-ipc[=true|false]", in roff.
std::string option_tag(const Option& option);
/// As a key of a configuration file: "max-scenes = UINT", in roff.
std::string key_tag(const Option& option);
/// What it is for, its words, range, default, variable, and the options that it needs or excludes.
std::string option_text(const Option& option);

/// "Contacts of one step": "contacts of one step", unless the first word is an abbreviation.
std::string as_phrase(const std::string& text);

}  // namespace collided::manual
