#pragma once
// The subcommands of collidectl, one file each. Every function adds its subcommand, whose callback does the work.

#include <CLI/CLI.hpp>

namespace collided::cli {

void add_detect(CLI::App& app);
void add_batch(CLI::App& app);
void add_merge(CLI::App& app);
void add_stream(CLI::App& app);
void add_replay(CLI::App& app);
void add_render(CLI::App& app);
void add_watch(CLI::App& app);
void add_view(CLI::App& app);
void add_estimate(CLI::App& app);
void add_scenes(CLI::App& app);
void add_export(CLI::App& app);
void add_info(CLI::App& app);
void add_tradeoff(CLI::App& app);
void add_bench(CLI::App& app);
void add_load(CLI::App& app);
void add_completion(CLI::App& app);
void add_manual(CLI::App& app);

}  // namespace collided::cli
