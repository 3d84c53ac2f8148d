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

/// An empty value, as of a variable of the shell that is not set, is bad usage for every option and argument, instead
/// of what is meant by none. Called once all commands are there.
void refuse_empty_values(CLI::App& app);

/// What is wrong with a command line that `app` could not parse, in one line.
std::string usage_message(const CLI::App& app, const CLI::Error& error);

/// `text` with control bytes, as names of files can have, as \xNN: they neither break a line nor steer a terminal.
std::string without_controls(const std::string& text);

/// Help whose usage line shows every file that can be given, as in "FRAME [FRAME]" or "[FRAME...]".
std::shared_ptr<CLI::FormatterBase> usage_formatter();

}  // namespace collided::cli
