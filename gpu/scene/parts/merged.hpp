#pragma once
// The answers of all parts of a scene as the answer of one: contacts in canonical order, the same bytes as one device
// gives. No contact is in two of them (base/share.hpp).

#include <memory>
#include <vector>

#include "gpu/contacts/answer_room.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Contacts of all parts, each part's in order, in one block of memory.
class MergedContacts {
 public:
  /// `parts` stay where they are, and as they are until all contacts are in their places.
  explicit MergedContacts(const std::vector<FrameResult>& parts) : parts_(parts) {}

  /// Makes room for them. Throws as AnswerRoom does.
  void take(AnswerRoom& room, uint64_t bytes_beside_contact);
  /// Puts one part's contacts where they belong; from as many threads as there are parts.
  void place(size_t part) const;
  /// Once all are there; none are here then.
  void move_to(FrameResult& result);
  void clear() { contacts_ = {}, memory_ = nullptr; }

 private:
  void place(size_t part, ContactKind kind, ContactSet& to) const;

  const std::vector<FrameResult>& parts_;
  PerKind<ContactSet> contacts_;
  std::shared_ptr<std::byte> memory_;
};

/// All but the contacts themselves. `report`: of the frame. Times are those of the slowest part, counts sums.
FrameResult merged_facts(const std::vector<FrameResult>& parts, Report report);

}  // namespace collided
