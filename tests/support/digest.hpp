#pragma once
// One number for all result arrays of a frame (FNV-1a, 64 bit), to compare backends, threads and machines.

#include "gpu/detector.hpp"

namespace collided::test {

uint64_t digest(const ContactSet& contacts, uint64_t seed);
uint64_t digest(const FrameResult& result);

/// Byte for byte: distinguishes -0 from 0, and NaN equals itself.
bool same_bytes(const ContactSet& a, const ContactSet& b);
bool same_contacts(const FrameResult& a, const FrameResult& b);

}  // namespace collided::test
