#pragma once
// Shared by every call of the C library: it turns exceptions into codes, and handles structures of any version.

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "client/c/include/collided/collided.h"
#include "gpu/types.hpp"

namespace collided::c {

/// The call does not fit the state of the scene.
class FailedPrecondition : public std::runtime_error {
  using runtime_error::runtime_error;
};
/// A structure has a member of a later version.
class Unimplemented : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// Records the exception that is being handled as the thread's last error, and returns its code. Never throws.
collided_status record_current() noexcept;

/// Throws Unimplemented for a member that no version of the library knows yet.
inline void check_reserved(int32_t reserved, const std::string& field) {
  if (reserved != 0) throw Unimplemented(field + " is " + std::to_string(reserved) + "; it must be 0");
}

/// Runs `call` and turns what it throws into a code.
template <class Call>
collided_status guarded(const Call& call) noexcept {
  try {
    call();
    return COLLIDED_OK;
  } catch (...) {
    return record_current();
  }
}

/// Throws InvalidInput for null.
template <class T>
T* required(T* pointer, const std::string& field) {
  if (pointer == nullptr) throw InvalidInput(field, field + " is null");
  return pointer;
}

/// Throws InvalidInput for an array that is null and not empty, or longer than any array of a scene.
template <class T>
void check_array(const T* array, uint64_t count, const std::string& field, const std::string& count_field) {
  constexpr uint64_t kMax = ~uint32_t{0};
  if (count > kMax)
    throw InvalidInput(count_field,
                       count_field + " is " + std::to_string(count) + ", the limit is " + std::to_string(kMax));
  if (count > 0 && array == nullptr)
    throw InvalidInput(field, field + " is null, but " + count_field + " is " + std::to_string(count));
}

/// Bytes of a structure in its first version: a smaller one was not initialised.
template <class T>
inline constexpr size_t kFirstSize = 0;
template <>
inline constexpr size_t kFirstSize<collided_device_info> = 160;
template <>
inline constexpr size_t kFirstSize<collided_mesh> = 88;
template <>
inline constexpr size_t kFirstSize<collided_scene_spec> = 144;
template <>
inline constexpr size_t kFirstSize<collided_topology> = 72;
template <>
inline constexpr size_t kFirstSize<collided_update> = 80;
template <>
inline constexpr size_t kFirstSize<collided_frame> = 104;
template <>
inline constexpr size_t kFirstSize<collided_contacts> = 72;
template <>
inline constexpr size_t kFirstSize<collided_facts> = 200;
template <>
inline constexpr size_t kFirstSize<collided_mesh_pair> = 40;

/// Throws InvalidInput for a size that no version of the structure has.
template <class T>
size_t check_size(const T* structure, const std::string& field) {
  static_assert(kFirstSize<T> > 0 && kFirstSize<T> <= sizeof(T));
  constexpr size_t kMax = 4096;
  size_t size = 0;
  std::memcpy(&size, required(structure, field), sizeof(size));
  if (size < kFirstSize<T> || size > kMax)
    throw InvalidInput(field + ".struct_size", field + ".struct_size is " + std::to_string(size) +
                                                   "; set it to sizeof, " + std::to_string(sizeof(T)) + " here");
  return size;
}

/// Copies a structure of any version. Throws InvalidInput, and Unimplemented if it has members of a later version.
template <class T>
T read_structure(const T* from, const std::string& field) {
  const size_t size = check_size(from, field);
  T structure{};
  std::memcpy(&structure, from, std::min(size, sizeof(T)));
  const auto* bytes = reinterpret_cast<const unsigned char*>(from);
  for (size_t i = sizeof(T); i < size; ++i)
    if (bytes[i] != 0)
      throw Unimplemented(field + " has a member at byte " + std::to_string(i) +
                          " that collided " COLLIDED_VERSION " does not know; it must be 0");
  return structure;
}

/// The i-th structure of an array whose elements have the size that the first one says.
template <class T>
T read_element(const T* array, uint64_t i, const std::string& name) {
  const size_t stride = check_size(array, name + "[0]");
  const std::string field = name + "[" + std::to_string(i) + "]";
  const T* element = reinterpret_cast<const T*>(reinterpret_cast<const char*>(array) + i * stride);
  if (const size_t size = check_size(element, field); size != stride)
    throw InvalidInput(field + ".struct_size", field + ".struct_size is " + std::to_string(size) + ", but that of " +
                                                   name + "[0] is " + std::to_string(stride));
  return read_structure(element, field);
}

/// Fills a structure of any version, whose size stays; what a later version has is 0.
template <class T>
void write_structure(T* to, T structure, const std::string& field) {
  structure.struct_size = check_size(to, field);
  std::memset(to, 0, structure.struct_size);
  std::memcpy(to, &structure, std::min(structure.struct_size, sizeof(T)));
}

/// Converts an enumerator to the engine's value, `values[enumerator]`; the first is the default. Throws InvalidInput.
template <class T, size_t N>
T choose(const T (&values)[N], int32_t enumerator, const std::string& field) {
  if (enumerator < 0 || enumerator >= static_cast<int32_t>(N))
    throw InvalidInput(field,
                       field + " is " + std::to_string(enumerator) + "; it must be from 0 to " + std::to_string(N - 1));
  return values[enumerator];
}

}  // namespace collided::c
