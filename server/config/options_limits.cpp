// Options that bound what clients may ask for: one for each row of the table of limits.
#include "server/config/accuracy_names.hpp"
#include "server/config/options.hpp"

namespace collided::server {
namespace {

void add_limit(CLI::App& app, const LimitRow<Accuracy>& row, Accuracy& accuracy) {
  const auto set = [&accuracy](const std::string& name) { accuracy = accuracy_named(name).value(); };
  app.add_option_function<std::string>(row.flag(), set, row.help)
      ->envname(variable_of(row.flag()))
      ->check(CLI::IsMember(accuracy_names()))
      ->default_str(name_of(accuracy));
}

// An option in MiB for a value in bytes.
void add_megabytes(CLI::App& app, const LimitRow<uint64_t>& row, uint64_t& bytes) {
  app.add_option_function<uint64_t>(
         row.flag(), [&bytes, row](uint64_t megabytes) { bytes = row.limit_of(megabytes); }, row.help)
      ->envname(variable_of(row.flag()))
      ->transform(number<uint64_t>(row.min, row.max))
      ->default_str(std::to_string(bytes >> 20));
}

template <class T>
void add_limit(CLI::App& app, const LimitRow<T>& row, T& limit) {
  if constexpr (std::is_same_v<T, uint64_t>)
    if (row.unit == LimitUnit::kMegabytes) return add_megabytes(app, row, limit);
  add<T>(app, row.flag(), limit, row.min, row.max, row.help);
}

}  // namespace

void add_limit_options(CLI::App& app, Limits& limits) {
  auto* group = app.add_option_group("Limits", "Requests that exceed them are refused");
  for_each_limit([group](const auto& row, auto& limit) { add_limit(*group, row, limit); }, limits);
}

}  // namespace collided::server
