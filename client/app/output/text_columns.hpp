#pragma once
// Columns of contacts in text files. Each format lists its columns in its own order, with its own names.

#include <array>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "client/cpp/contacts.hpp"

namespace collided::cli {

/// A column of Contacts.
template <class Entry>
struct TextColumn {
  std::string_view names;  ///< of an entry's components, separated by commas
  std::vector<Entry> client::Contacts::*values;
};
template <class Entry>
TextColumn(std::string_view, std::vector<Entry> client::Contacts::*) -> TextColumn<Entry>;

/// True for a column that Contacts has.
template <class Column>
concept HasValues = requires(Column column) {
  column.values;
};

/// The number of columns of Contacts in a format's list, which may have other columns too.
template <class... Columns>
constexpr int count_columns(const std::tuple<Columns...>&) {
  return (0 + ... + static_cast<int>(HasValues<Columns>));
}

/// Returns the components of an entry.
template <class T, size_t N>
constexpr std::array<T, N> components(const std::array<T, N>& entry) {
  return entry;
}
template <class T>
requires std::is_arithmetic_v<T>
constexpr std::array<T, 1> components(T entry) { return {entry}; }

/// visit(column) for each column of a format.
template <class Visit, class... Columns>
constexpr void for_each_text_column(const std::tuple<Columns...>& columns, const Visit& visit) {
  std::apply([&](const auto&... column) { (visit(column), ...); }, columns);
}

}  // namespace collided::cli
