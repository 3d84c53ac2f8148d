#pragma once
// Error messages for bad command lines, with suggestions.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

namespace collided::cli {

/// Levenshtein distance: how many letters to insert, delete or replace to turn `a` into `b`.
size_t edit_distance(const std::string& a, const std::string& b);

/// The word of `known` closest to `word`, leading dashes aside; empty if none is close enough to have been meant.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

/// What is wrong with a command line that `app` could not parse, in one line.
std::string usage_message(const CLI::App& app, const CLI::Error& error);

/// Help whose usage line shows every file that can be given, as in "FRAME [FRAME]" or "[FRAME...]".
std::shared_ptr<CLI::FormatterBase> usage_formatter();

}  // namespace collided::cli
