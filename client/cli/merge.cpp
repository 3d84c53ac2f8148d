// collidectl merge: the results of all shards of 'batch' in one table.

#include "client/cli/batch/merge.hpp"

#include <cstdio>
#include <memory>

#include "client/app/options/usage_error.hpp"
#include "client/app/output/output.hpp"
#include "client/app/report/numbers.hpp"
#include "client/cli/batch/outcome.hpp"
#include "client/cli/commands.hpp"

namespace collided::cli {

namespace {

void run(const MergeOptions& options) {
  check_one_output(options.out, options.json);
  check_distinct({{"--out", options.out}, {"--contacts", options.contacts}});
  if (options.json && is_standard_output(options.contacts))
    throw UsageError("--json and --contacts - both want standard output");
  check_writable("--out", options.out);
  check_writable("--contacts", options.contacts);
  const Json summary = merge_results(options);
  const auto count = [&](const char* name) { return count_text(summary[name].get<uint64_t>()); };
  const std::string text = "pairs " + count("pairs") + ", shards " + count("shards") + ", failed " +
                           count("failed_pairs") + "; " + options.out + "\n";
  if (options.json)
    print_line(json_text(summary));
  else
    print_summary(is_standard_output(options.contacts) ? options.contacts : options.out, text);
  check_failed_pairs(summary);
}

}  // namespace

void add_merge(CLI::App& app) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App& command = *app.add_subcommand("merge", "One table of the results of all shards of 'batch'");
  command.footer(
      "Every shard must be there and finished, of the same pairs and options, and every pair must be in it once; else\n"
      "nothing is written, and the error names what is missing. The table does not depend on the number of shards.\n"
      "\n"
      "  collidectl merge results --out pairs.csv --contacts contacts.csv\n"
      "\n"
      "Exit codes: 0 done, 1 failure, 2 bad usage, 3 done, but some pairs failed, as the table says.");
  command.add_option("RESULTS", options->folder, "Folder with the results")->type_name("FOLDER")->required();
  command.add_option("--out", options->out, "CSV file with a row for each pair; -: standard output")
      ->type_name("FILE")
      ->required();
  command.add_option("--contacts", options->contacts, "CSV file with all contacts, if 'batch --contacts' kept them")
      ->type_name("FILE");
  command.add_flag("--json", options->json, "Print the summary as one JSON object");
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
