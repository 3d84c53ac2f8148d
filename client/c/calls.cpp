#include "client/c/calls.hpp"

#include <new>

namespace {

/// Text that always has room for a message, if memory ends while one is made.
struct LastError {
  std::string message, field;
  bool is_out_of_memory = false;
};
thread_local LastError last_error;

collided_status record(collided_status status, const char* message, const std::string& field = {}) noexcept {
  try {
    last_error.message = message;
    last_error.field = field;
    last_error.is_out_of_memory = false;
  } catch (...) {
    last_error.is_out_of_memory = true;
  }
  return status;
}

constexpr const char* kOutOfMemory = "the process is out of memory";

}  // namespace

namespace collided::c {

collided_status record_current() noexcept {
  try {
    throw;
  } catch (const InvalidInput& e) {
    return record(COLLIDED_INVALID_ARGUMENT, e.what(), e.field());
  } catch (const FailedPrecondition& e) {
    return record(COLLIDED_FAILED_PRECONDITION, e.what());
  } catch (const Unimplemented& e) {
    return record(COLLIDED_UNIMPLEMENTED, e.what());
  } catch (const ResourceExhausted& e) {
    return record(COLLIDED_RESOURCE_EXHAUSTED, e.what());
  } catch (const std::bad_alloc&) {
    return record(COLLIDED_RESOURCE_EXHAUSTED, kOutOfMemory);
  } catch (const std::length_error&) {  // of an array that is longer than any memory
    return record(COLLIDED_RESOURCE_EXHAUSTED, kOutOfMemory);
  } catch (const DeviceError& e) {
    return record(COLLIDED_UNAVAILABLE, e.what());
  } catch (const Cancelled& e) {
    return record(COLLIDED_CANCELLED, e.what());
  } catch (const std::exception& e) {
    return record(COLLIDED_INTERNAL, e.what());
  } catch (...) {
    return record(COLLIDED_INTERNAL, "unknown error");
  }
}

}  // namespace collided::c

const char* collided_error_message(void) {
  return last_error.is_out_of_memory ? kOutOfMemory : last_error.message.c_str();
}
const char* collided_error_field(void) { return last_error.is_out_of_memory ? "" : last_error.field.c_str(); }

uint32_t collided_abi_version(void) { return COLLIDED_ABI_VERSION; }
const char* collided_version(void) { return COLLIDED_VERSION; }
