#pragma once
// The columns of an answer in one block of the host's memory, and the contacts of each kind within them.

#include <memory>
#include <vector>

#include "gpu/contacts/columns.hpp"
#include "gpu/step/answer_room.hpp"

namespace collided {

class ColumnsOnHost {
 public:
  /// Of `count` contacts that lie in `columns` on the backend.
  ColumnsOnHost(const ContactColumns& columns, uint64_t count)
      : count_(count),
        elements_(place(columns.elements)),
        toi_(place(columns.toi)),
        distance_(place(columns.distance)),
        weights_(place(columns.weights)),
        flags_(place(columns.flags)) {}

  /// Takes the memory; `beside`: as AnswerRoom has it.
  void take(AnswerRoom& room, uint64_t beside) { memory_ = room.take(bytes_, beside); }
  const std::shared_ptr<std::byte>& memory() const { return memory_; }

  /// copy(to, from, bytes) for each column.
  template <class Copy>
  void for_each(const Copy& copy) const {
    for (const Place* p : {&elements_, &toi_, &distance_, &weights_, &flags_})
      if (p->from != nullptr) copy(memory_.get() + p->offset, p->from, p->bytes);
  }

  /// Vertex-triangle or edge-edge contacts [begin, end). `has_data`: they have more than their ids.
  ContactSet contacts(uint64_t begin, uint64_t end, bool has_data) const {
    ContactSet set;
    set.elements = column<std::array<uint32_t, 2>>(elements_, begin, end);
    if (!has_data) return set;
    set.toi = column<double>(toi_, begin, end);
    set.distance = column<double>(distance_, begin, end);
    set.weights = column<std::array<double, 2>>(weights_, begin, end);
    set.flags = column<uint8_t>(flags_, begin, end);
    return set;
  }
  /// `has_flags`: they were tested.
  ContactSet triangle_pairs(uint64_t begin, uint64_t end, bool has_flags) const {
    ContactSet set;
    set.elements = column<std::array<uint32_t, 2>>(elements_, begin, end);
    if (has_flags) set.flags = column<uint8_t>(flags_, begin, end);
    return set;
  }

 private:
  struct Place {
    const void* from = nullptr;  ///< null: not wanted
    uint64_t offset = 0, bytes = 0;
  };
  template <class T>
  Place place(const Span<T>& column) {
    constexpr uint64_t kAlignment = 64;
    if (column.empty()) return {};
    const Place place{column.data, bytes_, count_ * sizeof(T)};
    bytes_ += (place.bytes + kAlignment - 1) / kAlignment * kAlignment;
    return place;
  }
  template <class T>
  Column<T> column(const Place& place, uint64_t begin, uint64_t end) const {
    if (place.from == nullptr || begin == end) return {};
    T* values = reinterpret_cast<T*>(memory_.get() + place.offset) + begin;
    return Column<T>(std::shared_ptr<T>(memory_, values), end - begin);
  }

  uint64_t count_, bytes_ = 0;
  Place elements_, toi_, distance_, weights_, flags_;
  std::shared_ptr<std::byte> memory_;
};

}  // namespace collided
