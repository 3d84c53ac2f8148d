#pragma once
// Man pages of a program, its commands and its configuration file.

#include <string>

#include "client/cli/manual/program.hpp"

namespace collided::manual {

/// PROGRAM(SECTION), with its commands, options and its own sections.
std::string program_page(const Program& program);
/// PROGRAM-COMMAND(SECTION)
std::string command_page(const Program& program, const Command& command);

/// FILE(5): the options that may come from a configuration file, as its keys.
struct ConfigFile {
  std::string name, summary, intro, example;
};
std::string config_page(const Program& program, const ConfigFile& file);

}  // namespace collided::manual
