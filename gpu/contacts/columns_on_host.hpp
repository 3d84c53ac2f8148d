#pragma once
// The columns of an answer in one block of the host's memory, and the contacts of each kind within them.

#include <memory>
#include <vector>

#include "gpu/contacts/answer_room.hpp"
#include "gpu/contacts/columns.hpp"

namespace collided {

class ColumnsOnHost {
 public:
  /// Of the contacts [begin, end) that lie in `columns` on the backend.
  ColumnsOnHost(const ContactColumns& columns, uint64_t begin, uint64_t end) : begin_(begin), count_(end - begin) {
    constexpr uint64_t kAlignment = 64;
    for_each_field(
        [&](ContactField, const auto& column, auto& place) {
          if (column.empty()) return;
          place = {column.data + begin, bytes_};
          bytes_ += (place.bytes(count_) + kAlignment - 1) / kAlignment * kAlignment;
        },
        columns, places_);
  }

  /// Takes the memory; `beside`: as AnswerRoom has it.
  void take(AnswerRoom& room, uint64_t beside) { memory_ = room.take(bytes_, beside); }
  const std::shared_ptr<std::byte>& memory() const { return memory_; }

  /// copy(to, from, bytes) for each column that the backend fills in. Signed distances are the host's.
  template <class Copy>
  void for_each(const Copy& copy) const {
    for_each_field(
        [&](ContactField field, const auto& place) {
          if (place.from != nullptr && field != ContactField::kSignedDistance)
            copy(memory_.get() + place.offset, place.from, place.bytes(count_));
        },
        places_);
  }

  /// Contacts [begin, end) of the list, with those of these fields that there are.
  ContactSet contacts(uint64_t begin, uint64_t end, FieldSet fields) const {
    ContactSet set;
    for_each_field(
        [&](ContactField field, auto& column, const auto& place) {
          if (fields.has(field)) column = column_at(place, begin - begin_, end - begin_);
        },
        set, places_);
    return set;
  }

 private:
  template <class T>
  struct Place {
    const T* from = nullptr;  ///< null: not wanted
    uint64_t offset = 0;

    uint64_t bytes(uint64_t count) const { return count * sizeof(T); }
  };
  template <class T>
  Column<T> column_at(const Place<T>& place, uint64_t begin, uint64_t end) const {
    if (place.from == nullptr || begin == end) return {};
    T* values = reinterpret_cast<T*>(memory_.get() + place.offset) + begin;
    return Column<T>(std::shared_ptr<T>(memory_, values), end - begin);
  }

  uint64_t begin_, count_, bytes_ = 0;
  PerField<Place> places_;
  std::shared_ptr<std::byte> memory_;
};

}  // namespace collided
