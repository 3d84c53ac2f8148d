// collidectl batch: the contacts of each pair of frames of a data set, or of one shard of them.

#include <cstdio>
#include <memory>

#include "client/app/options/exclusion_options.hpp"
#include "client/app/options/options.hpp"
#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/numbers.hpp"
#include "client/cli/batch/outcome.hpp"
#include "client/cli/batch/run.hpp"
#include "client/cli/commands.hpp"

namespace collided::cli {

namespace {

constexpr const char* kFooter =
    "DATASET is a folder, a glob in quotes, or a list. In a folder and those below it, files whose names differ in\n"
    "their last number alone are a sequence, and its pairs are frames as far apart as its closest two, so that there\n"
    "is none across a gap. A list has a line for each pair: two names, separated by a comma, relative to its folder.\n"
    "\n"
    "Shard I of N (counted from 1) has the pairs I, I + N, I + 2 N and so on. Its results are "
    "FOLDER/shard-I-of-N.part\n"
    "until it is finished, then .results; 'collidectl merge' makes one table of all shards. Whatever ended it, the "
    "same\n"
    "command goes on: a pair that has a result is not done again. A pair whose files are missing, broken or refused\n"
    "gets the reason as its result, and the others go on.\n"
    "\n"
    "  collidectl batch data --list > pairs.csv\n"
    "  collidectl batch pairs.csv --out results --shard 3/16\n"
    "  collidectl merge results --out pairs-found.csv\n"
    "\n"
    "Exit codes: 0 done, 1 failure, what is done is kept, 2 bad usage, 3 done, but some pairs failed, 128 + n "
    "interrupted by signal n.";

void check_usage(const BatchOptions& options) {
  check_usage(options.detection);
  if (options.list != options.out.empty()) throw UsageError("batch needs one of --out FOLDER and --list");
}

void show_notes(const Dataset& dataset) {
  constexpr size_t kShown = 5;
  for (size_t i = 0; i < dataset.notes.size() && i < kShown; ++i)
    std::fprintf(stderr, "%s\n", dataset.notes[i].c_str());
  if (dataset.notes.size() > kShown)
    std::fprintf(stderr, "and %zu more such files or gaps\n", dataset.notes.size() - kShown);
}

void print(const BatchOptions& options, const Json& summary) {
  if (options.json) return print_line(json_text(summary));
  const auto count = [&](const char* name) { return count_text(summary[name].get<uint64_t>()); };
  std::printf("shard %s: pairs %s, done before %s, failed %s; %s\n", summary["shard"].get<std::string>().c_str(),
              count("pairs").c_str(), count("resumed_pairs").c_str(), count("failed_pairs").c_str(),
              summary["out"].get<std::string>().c_str());
}

void run(const BatchOptions& options) {
  check_usage(options);
  const Shard shard = parse_shard(options.shard);
  const Dataset dataset = read_dataset(options.dataset, options.detection.mode == "dcd" ? 1 : 2);
  show_notes(dataset);
  if (options.list) return (void)std::fputs(list_text(dataset).c_str(), stdout);
  make_folder("--out", options.out);
  const Json summary = run_shard(options, dataset, shard);
  print(options, summary);
  check_failed_pairs(summary);
}

}  // namespace

void add_batch(CLI::App& app) {
  auto options = std::make_shared<BatchOptions>();
  CLI::App& command = *app.add_subcommand("batch", "Contacts of all pairs of frames of a data set, in shards");
  command.footer(kFooter);
  command.add_option("DATASET", options->dataset, "Folder, glob in quotes, or list of pairs of mesh files")
      ->type_name("FILE")
      ->required();
  command.add_option("--out", options->out, "Folder for the results of all shards; created if missing")
      ->type_name("FOLDER");
  command.add_option("--shard", options->shard, "Which of how many parts to do, 1/N to N/N")
      ->type_name("I/N")
      ->capture_default_str();
  command.add_flag("--contacts", options->keep_contacts, "Keep all contacts, too, for 'collidectl merge --contacts'");
  command.add_flag("--retry-failed", options->retry_failed, "Try pairs again that failed before");
  command.add_flag("--list", options->list,
                   "Only print the pairs, as a list for the current folder that DATASET can be");
  add_detection_options(command, options->detection);
  add_ring_option(command, options->exclude_rings);
  add_server_options(command, options->server);
  add_automatic_format_option(command, options->position_format);
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
