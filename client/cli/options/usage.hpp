#pragma once
// Bad usage in words: which word is wrong, and what may have been meant.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

namespace collided::cli {

/// Letters to put in, leave out or replace until `a` is `b`.
size_t edit_distance(const std::string& a, const std::string& b);

/// The one of `known` that is nearest to `word`, leading dashes aside; empty if none is near enough to have been meant.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

/// What is wrong with a command line that `app` could not parse.
std::string usage_message(const CLI::App& app, const CLI::Error& error);

/// Help whose usage line has each file that can be given, as "FRAME [FRAME]".
std::shared_ptr<CLI::FormatterBase> usage_formatter();

}  // namespace collided::cli
