// The failpoints of `collided_faulty`: the linker sends every call of SYMBOL to __wrap_SYMBOL, and __real_SYMBOL is
// what it would have been.
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string_view>
#include <system_error>

#include "tests/integration/faults/control.hpp"

namespace {

using collided::test::FaultControl;

constexpr size_t kLarge = 256;  // bytes; smaller allocations do not fail

FaultControl* control() {
  static FaultControl* const one = [] {
    const char* const file = std::getenv(collided::test::kControlVariable);
    return file ? collided::test::map_control(file) : nullptr;
  }();
  return one;
}

// Until the control is mapped nothing fails, the calls that map it among them.
std::atomic<FaultControl*> mapped = nullptr;
[[maybe_unused]] const bool is_mapped = (mapped = control()) != nullptr;

// The error with which this call fails; 0 if it does not.
int error_of(const char* symbol) {
  FaultControl* const now = mapped;
  if (!now || now->calls_left == 0 || std::strcmp(now->symbol, symbol) != 0) return 0;
  const int error = now->error;
  int left = now->calls_left;
  while (left > 1)
    if (now->calls_left.compare_exchange_weak(left, left - 1)) return 0;
  if (left == 0 || (!now->lasts && !now->calls_left.compare_exchange_strong(left, 0))) return 0;
  ++now->failed;
  return error;
}

// What a function returns that fails.
long result_of(std::string_view symbol, int error) {
  if (symbol.starts_with("cuda") || symbol.starts_with("__cuda")) return error;
  if (symbol == "getaddrinfo") return -10;  // EAI_MEMORY
  errno = error;
  return symbol == "aligned_alloc" ? 0 : -1;
}

}  // namespace

struct Failure {
  long fails, result;
};

extern "C" {

[[gnu::used]] Failure collided_failpoint(const char* symbol) {
  const int kept = errno;
  if (const int error = error_of(symbol)) return {1, result_of(symbol, error)};
  errno = kept;
  return {0, 0};
}

void* __real__Znwm(size_t bytes);
void* __wrap__Znwm(size_t bytes) {
  if (bytes >= kLarge && error_of("_Znwm")) throw std::bad_alloc();
  return __real__Znwm(bytes);
}

void* __real__ZnwmRKSt9nothrow_t(size_t bytes, const std::nothrow_t& tag);
void* __wrap__ZnwmRKSt9nothrow_t(size_t bytes, const std::nothrow_t& tag) {
  return error_of("_ZnwmRKSt9nothrow_t") ? nullptr : __real__ZnwmRKSt9nothrow_t(bytes, tag);
}

void* __real__ZnwmSt11align_val_t(size_t bytes, std::align_val_t alignment);
void* __wrap__ZnwmSt11align_val_t(size_t bytes, std::align_val_t alignment) {
  if (bytes >= kLarge && error_of("_ZnwmSt11align_val_t")) throw std::bad_alloc();
  return __real__ZnwmSt11align_val_t(bytes, alignment);
}

// std::thread's own start. The caller owns the state, and frees it.
#define START _ZNSt6thread15_M_start_threadESt10unique_ptrINS_6_StateESt14default_deleteIS1_EEPFvvE
#define NAMED(prefix, name) prefix##name
#define REAL(name) NAMED(__real_, name)
#define WRAP(name) NAMED(__wrap_, name)
#define TEXT(name) #name
#define NAME(name) TEXT(name)
void REAL(START)(void* thread, void* state, void (*depend)());
void WRAP(START)(void* thread, void* state, void (*depend)()) {
  if (const int error = error_of(NAME(START))) throw std::system_error(error, std::generic_category(), "thread");
  REAL(START)(thread, state, depend);
}

}  // extern "C"

// Of any signature: keeps the registers of the arguments while it asks whether to fail. x86-64 only.
#define FAILPOINT(symbol)                                                                      \
  asm(".text\n.globl __wrap_" #symbol "\n.type __wrap_" #symbol ", @function\n__wrap_" #symbol \
      ":\n"                                                                                    \
      "push %rdi\npush %rsi\npush %rdx\npush %rcx\npush %r8\npush %r9\npush %rax\n"            \
      "lea 1f(%rip), %rdi\ncall collided_failpoint\nmov %rax, %r10\nmov %rdx, %r11\n"          \
      "pop %rax\npop %r9\npop %r8\npop %rcx\npop %rdx\npop %rsi\npop %rdi\n"                   \
      "test %r10, %r10\njne 2f\njmp __real_" #symbol                                           \
      "@PLT\n"                                                                                 \
      "2: mov %r11, %rax\nret\n.size __wrap_" #symbol ", .-__wrap_" #symbol                    \
      "\n"                                                                                     \
      ".section .rodata\n1: .string \"" #symbol "\"\n.text\n");
#include "failpoints.inc"
