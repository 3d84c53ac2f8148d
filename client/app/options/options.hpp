#pragma once
// Options that several subcommands share.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "client/app/options/values.hpp"

namespace collided::cli {

void add_server_options(CLI::App& command, ServerOptions& options);
void add_detection_options(CLI::App& command, DetectionOptions& options);
/// For subcommands that play a motion and can stop short of its end.
void add_advance_options(CLI::App& command, DetectionOptions& options);

/// Replaces --engine of add_detection_options with one that takes several engines.
void add_engines_option(CLI::App& command, std::vector<std::string>& engines);
/// --position-format, one of position_formats().
void add_position_format_option(CLI::App& command, std::string& format);

/// The same, or kAutomaticFormat, for subcommands that read mesh files.
void add_automatic_format_option(CLI::App& command, std::string& format);

}  // namespace collided::cli
