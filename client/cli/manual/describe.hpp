#pragma once
// A program of CLI11, described.

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "client/cli/manual/program.hpp"

namespace collided::manual {

/// The words of types that have no check of their own, such as the names of scenes for "SCENE".
using KnownWords = std::map<std::string, std::vector<std::string>>;

/// All commands, options and arguments that --help shows. What has no group is hidden.
Program describe(const CLI::App& app, const KnownWords& known = {});

}  // namespace collided::manual
