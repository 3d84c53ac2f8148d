#pragma once
// What happens to contacts once they are on the host. Lists may be long: the loops ask whether the frame goes on.

#include "gpu/exact/crossings.hpp"
#include "gpu/exact/decision.hpp"
#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Contacts that only exact arithmetic can decide: those that are not certain, those whose time of impact is 0 though
/// they may not touch at the start, and those whose time was left far off by the limit of iterations.
size_t count_undecided(CpuLoops& loops, const ContactSet& set);
/// Their places; `count`: of them. Pairs that the step has decided to be apart come last.
std::vector<size_t> undecided(CpuLoops& loops, const ContactSet& set, size_t count);
/// How many of the places are not of such pairs.
size_t count_open(const ContactSet& set, const std::vector<size_t>& places);

/// Takes the answers for the contacts at `places`: what is no contact goes, the rest is certain. `normals`: empty if
/// the set has none.
void apply(CpuLoops& loops, ContactSet& set, const std::vector<size_t>& places, const std::vector<ExactAnswer>& answers,
           const std::vector<Normal>& normals);

/// Takes what exact arithmetic says of the edges and triangles at `places`: what does not cross goes, the rest is
/// certain.
void apply(CpuLoops& loops, ContactSet& set, const std::vector<size_t>& places,
           const std::vector<EdgeTriangleVerdict>& verdicts);

/// Removes kFlagOnArc from all flags.
void take_marks(CpuLoops& loops, ContactSet& set);

/// Leaves one contact in all: the earliest; of several the first of the first kind.
void keep_earliest(CpuLoops& loops, PerKind<ContactSet>& contacts);

/// 1 if there is none, or no time. `ignore_separating`: of those that do not have kFlagSeparating.
double earliest_toi(CpuLoops& loops, const PerKind<ContactSet>& contacts, bool ignore_separating);

}  // namespace collided
