#pragma once
// The answers of all shards of a scene as the answer of one: contacts in canonical order, the same bytes as one device
// gives. No contact is in two of them (base/share.hpp).

#include <memory>
#include <vector>

#include "gpu/contacts/answer_room.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Contacts of all shards, each shard's in order, in one block of memory.
class MergedContacts {
 public:
  /// Selects the contacts of a shard's answer that are merged.
  using Of = const PerKind<ContactSet>& (*)(const FrameResult&);

  /// `shards` stay where they are, and as they are until all contacts are in their places.
  MergedContacts(const std::vector<FrameResult>& shards, Of of) : shards_(shards), of_(of) {}

  /// Makes room for them. Throws as AnswerRoom does.
  void take(AnswerRoom& room, uint64_t bytes_beside_contact);
  /// Puts one shard's contacts where they belong; from as many threads as there are shards.
  void place(size_t shard) const;
  /// Moves the contacts out once all are there. Returns their memory, which may be null.
  std::shared_ptr<const void> move_to(PerKind<ContactSet>& contacts);
  void clear() { contacts_ = {}, memory_ = nullptr; }

 private:
  const ContactSet& set_of(const FrameResult& shard, ContactKind kind) const { return value_of(of_(shard), kind); }
  void place(size_t shard, ContactKind kind, ContactSet& to) const;

  const std::vector<FrameResult>& shards_;
  const Of of_;
  PerKind<ContactSet> contacts_;
  std::shared_ptr<std::byte> memory_;
};

/// All but the contacts themselves. `report`: of the frame. Times are those of the slowest shard, counts sums.
FrameResult merged_facts(const std::vector<FrameResult>& shards, Report report);

}  // namespace collided
