#pragma once
// What a backend provides: every verb is stated here, once. CpuExec and CudaExec are checked against it, and whatever
// takes an Exec asks for an Executor.
//
// An Exec belongs to one scene and is used by one thread at a time. Its verbs put work in line, and that work runs in
// the order of the calls, each after the one before has ended: CpuExec works before it returns, CudaExec later, on its
// stream. Lengths are items unless they are called bytes. `name` is what profilers and errors call the work; it is a
// string literal. Any verb may throw DeviceError, those that allocate ResourceExhausted, and those that ask whether the
// frame goes on (Asks) what the question throws.

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "gpu/exec/asks.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/exec/memory_ledger.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

class CpuLoops;

// Functors that loops run. They are copied to the backend, and their operators are const.

/// f(i): the work on item i.
template <class F>
concept ItemFunctor = std::invocable<const F&, uint64_t>;

/// f(i, group, shared): the work of one thread of a group (Group) on item i. F::Shared is memory of the group, not
/// initialised; F::kGroupSize is the number of its threads on a GPU. F::kGroupsOfProcessor, if it is there, limits how
/// many groups a GPU's processor is given at once: where items are few, most groups would find none.
template <class F>
concept GroupFunctor = requires(const F& f, const Group& group, typename F::Shared& shared) {
  { F::kGroupSize } -> std::convertible_to<uint32_t>;
  f(uint64_t{}, group, shared);
};

/// f.item(i) is item i, of `parts` parts, of which part(k) is the k-th. What there is to do for a part is
/// f.find(part, f.look(part)), and f.act(item, found) does it unless it is kNothing.
template <class F>
concept PartsFunctor = requires(const F& f, const typename F::Item& item, uint32_t k) {
  { f.item(uint64_t{}) } -> std::same_as<typename F::Item>;
  { item.parts } -> std::convertible_to<uint32_t>;
  { item.part(k) } -> std::same_as<uint32_t>;
  { f.find(k, f.look(k)) } -> std::same_as<uint32_t>;
  f.act(item, k);
};

/// item.walk() gives the parts from the first on, one a call of next(). F::kWalks: whether that costs a GPU less than
/// part(k).
template <class F>
concept WalkingFunctor = PartsFunctor<F> && requires(const typename F::Item& item) {
  { F::kWalks } -> std::convertible_to<bool>;
  { item.walk().next() } -> std::same_as<uint32_t>;
};

/// item.walk_from(k) gives the parts from the k-th on, so that an item may be left half done.
template <class F>
concept ManyPartsFunctor = PartsFunctor<F> && requires(const typename F::Item& item, uint32_t k) {
  { item.walk_from(k).next() } -> std::same_as<uint32_t>;
};

/// f.begin(i, state), then f.step(state) until state.is_over(), then f.finish(state); neither of them where begin()
/// leaves the state over, as it is made.
template <class F>
concept ResumableFunctor = std::default_initializable<typename F::State> &&
    requires(const F& f, typename F::State& state) {
  f.begin(uint64_t{}, state);
  f.step(state);
  f.finish(state);
  { state.is_over() } -> std::same_as<bool>;
};

namespace probe {

// The least that each verb can be asked with.
struct ForItem {
  COLLIDED_HD void operator()(uint64_t) const {}
};
struct ForGroup {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 32;
  COLLIDED_HD void operator()(uint64_t, const Group&, Nothing&) const {}
};
struct ForParts {
  struct Walk {
    COLLIDED_HD uint32_t next() { return 0; }
  };
  struct Item {
    static constexpr uint32_t kShared = 1;
    uint32_t parts;
    COLLIDED_HD uint32_t part(uint32_t k) const { return k; }
    COLLIDED_HD Walk walk() const { return {}; }
    COLLIDED_HD Walk walk_from(uint32_t) const { return {}; }
  };
  static constexpr bool kWalks = true;
  COLLIDED_HD Item item(uint64_t) const { return {0}; }
  COLLIDED_HD uint32_t look(uint32_t) const { return 0; }
  COLLIDED_HD uint32_t find(uint32_t, uint32_t) const { return kNothing; }
  COLLIDED_HD void act(const Item&, uint32_t) const {}
};
struct Resumable {
  struct State {
    COLLIDED_HD bool is_over() const { return true; }
  };
  COLLIDED_HD void begin(uint64_t, State&) const {}
  COLLIDED_HD void step(State&) const {}
  COLLIDED_HD void finish(State&) const {}
};
struct NumberOf {
  COLLIDED_HD uint64_t operator()(uint64_t i) const { return i; }
};
struct Add {
  COLLIDED_HD uint64_t operator()(uint64_t a, uint64_t b) const { return a + b; }
};
struct Check {
  bool is_clean() const { return true; }
  COLLIDED_HD void operator()(uint64_t, uint64_t*) const {}
};
struct Write {
  bool has_data() const { return false; }
  COLLIDED_HD void operator()(uint64_t, uint64_t, uint64_t) const {}
};
struct Host {
  void operator()() const {}
};

}  // namespace probe

/// What a Buffer allocates from. `part` names who holds the bytes in the scene's ledger.
template <class M>
concept Memory = requires(M& memory, const std::string& part, void* at, uint64_t bytes) {
  /// Aligned to 64 bytes at least, not initialised, booked before it is allocated.
  { memory.allocate(part, bytes) } -> std::same_as<void*>;
  /// With the same part and bytes.
  { memory.deallocate(part, at, bytes) } -> std::same_as<void>;
};

template <class Exec>
concept OwnsMemory = Memory<Exec> && requires(Exec& exec, const Exec& same, uint64_t bytes) {
  { same.ledger() } -> std::same_as<const MemoryLedger&>;
  /// Memory of the host that downloads go to at full speed, until the next call.
  { exec.host_memory(bytes) } -> std::same_as<std::byte*>;
  /// The same, kept by who holds it, also when the Exec is gone; aligned to 64 bytes, booked nowhere.
  { same.host_block(bytes) } -> std::same_as<std::shared_ptr<std::byte>>;
  /// Allocations since begin_frame().
  { same.allocations() } -> std::same_as<uint32_t>;
};

/// Bytes from and to trivially copyable values; the ranges of a copy do not overlap.
template <class Exec>
concept Copies = requires(Exec& exec, void* to, const void* from, uint64_t bytes) {
  /// From the host. Its memory must stay as it is until the next wait.
  { exec.upload(to, from, bytes) } -> std::same_as<void>;
  /// To the host; done when it returns, and so is all that was in line.
  { exec.download(to, from, bytes) } -> std::same_as<void>;
  /// To the host; done after wait().
  { exec.download_async(to, from, bytes) } -> std::same_as<void>;
  /// Within the backend.
  { exec.copy(to, from, bytes) } -> std::same_as<void>;
  { exec.fill_zero(to, bytes) } -> std::same_as<void>;
  /// Until nothing is in line.
  { exec.wait() } -> std::same_as<void>;
};

/// Loops over items [0, n), in any order and by many threads at once. A `Counted` length is read when the loop begins,
/// so that work before it in line may still change it.
template <class Exec>
concept RunsLoops = requires(Exec& exec, const char* name, uint64_t n, const Counted& counted, uint64_t* next,
                             const probe::ForItem& f, const probe::ForGroup& for_group,
                             const probe::ForParts& for_parts, const probe::Resumable& resumable) {
  /// ItemFunctor.
  { exec.for_each(name, n, f) } -> std::same_as<void>;
  { exec.for_each(name, counted, f) } -> std::same_as<void>;
  /// GroupFunctor.
  { exec.for_each_group(name, counted, for_group) } -> std::same_as<void>;
  /// WalkingFunctor, for items of a few parts.
  { exec.for_each_part(name, counted, for_parts) } -> std::same_as<void>;
  /// ManyPartsFunctor: threads share the parts of an item.
  { exec.for_each_of_many_parts(name, counted, for_parts) } -> std::same_as<void>;
  /// ResumableFunctor. `next` is a counter on the backend, 0 when the loop begins.
  { exec.for_each_resumable(name, counted, next, resumable) } -> std::same_as<void>;
};

/// What a thread cannot do by itself. All but reduce_into's `then` are in any order: operations must not depend on it.
template <class Exec>
concept Combines = requires(Exec& exec, const char* name, uint64_t n, const probe::NumberOf& transform,
                            uint64_t* result, const probe::Add& op, const probe::ForItem& then, Span<uint32_t> counts,
                            int bits, const SortArrays& arrays) {
  /// *result = op over transform(i), i in [0, n), from the identity on; then then(0). `result` is on the backend.
  { exec.reduce_into(name, n, transform, uint64_t{}, op, result, then) } -> std::same_as<void>;
  { exec.reduce_into(name, n, transform, uint64_t{}, op, result) } -> std::same_as<void>;
  /// In place: each value becomes the sum of those before it.
  { exec.exclusive_scan(name, counts) } -> std::same_as<void>;
  /// Stably by the keys, none of which has a bit above the lowest `bits`; 0 if the result is in `keys` and `values`
  /// (which may be empty), 1 if it is in the others. What the arrays without it hold is lost.
  { exec.sort_pairs(name, bits, arrays) } -> std::same_as<int>;
};

/// The order of a frame: steps of named stages, and what is known of them afterwards.
template <class Exec>
concept RunsFrames = requires(Exec& exec, const Exec& same, const char* name, uint64_t key, const uint64_t* result,
                              const probe::Host& f, const probe::Host& g) {
  /// The calling thread, which may be a new one, works on the Exec's device from here on.
  { exec.make_current() } -> std::same_as<void>;
  /// make_current(), and forgets the times and counts of the frame before.
  { exec.begin_frame() } -> std::same_as<void>;
  /// begin_frame(), then what f() returns.
  { exec.frame(f) } -> std::same_as<void>;
  /// Runs the work that f() puts in line, waits for it, asking whether the frame goes on, and returns the trivially
  /// copyable value that it left at `result` on the backend. Steps of one key must put the same work in line: a backend
  /// may call f() more than once, or replay what it recorded, as long as no memory was allocated since.
  { exec.step(key, result, f) } -> std::same_as<uint64_t>;
  /// Whether step() of that key can begin now; else steps run by parts sooner. The answer holds for the next step.
  { exec.can_step(key) } -> std::same_as<bool>;
  /// Runs f() as a step that is not recorded: f() may look at what it has done so far, allocate, and go on as that
  /// demands. Returns the value at `result` in the end.
  { exec.step_by_parts(result, f) } -> std::same_as<uint64_t>;
  /// Within such a step, or before a step: the value at `result`, of all that is in line. Waits as a step does.
  { exec.peek(result) } -> std::same_as<uint64_t>;
  /// Runs f() as a stage with a time of its own. Asks first whether the frame goes on, unless a step is only put in
  /// line.
  { exec.stage(name, f) } -> std::same_as<void>;
  /// Two things within a step that do not depend on each other and may run side by side. The second may not use
  /// reduce_into, exclusive_scan or sort_pairs.
  { exec.concurrently(f, g) } -> std::same_as<void>;
  /// Within a step, runs f() once, and again as long as it leaves a value other than 0 at `result` on the backend. f()
  /// must put the same work in line each time, and may have no stages.
  { exec.repeat(result, f) } -> std::same_as<void>;
  /// Of the frame, in the order that the stages ran. Waits.
  { exec.stage_times() } -> std::same_as<std::vector<StageTime>>;
  /// Of all steps of the frame.
  { same.step_milliseconds() } -> std::same_as<double>;
  { same.graph_launches() } -> std::same_as<uint32_t>;
  /// When the frame's question is asked.
  { exec.asks() } -> std::same_as<Asks&>;
  /// Loops on the host's cores, which ask too.
  { exec.host_loops() } -> std::same_as<CpuLoops&>;
};

/// Bytes that lie anywhere the backend can read.
using Source = std::span<const std::byte>;

/// Room for positions on their way to a backend; may outlive its Exec. Used by one thread at a time, which need not be
/// the scene's.
template <class S>
concept StagingRoom = requires(S& staging, uint64_t n, const std::vector<Source>& sources, void* stream,
                               const std::vector<uint64_t>& table, const uint64_t* place, const probe::Check& check) {
  /// Memory of the host to fill, of at least so many bytes; what was there before is lost.
  { staging.room(n) } -> std::same_as<std::span<std::byte>>;
  /// Makes the next bring() read its sources only after the work that this stream of the backend holds now; null: at
  /// once.
  { staging.follow(stream) } -> std::same_as<void>;
  /// Where the sources' bytes lie on the backend until the next call, each aligned to n bytes; null for those without
  /// any. They are read once; those in room() may be used where they are.
  { staging.bring(sources, n) } -> std::same_as<std::vector<const std::byte*>>;
  /// The same for a table that stays as it is meanwhile; after the sources.
  { staging.bring(table) } -> std::same_as<const uint64_t*>;
  /// check(i, first_bad) for i in [0, n), on the backend, after the sources; it may be left out if check.is_clean().
  /// `first_bad` are n verdicts, each kNoBadPlace at first. The second check is the same with its tables on the host,
  /// for sources that the host may read.
  { staging.check(n, n, check, check) } -> std::same_as<void>;
  /// The verdicts. Waits for the check, and so for all that was brought.
  { staging.first_bad() } -> std::same_as<std::span<const uint64_t>>;
  /// A value of what was brought. Waits.
  { staging.read(place) } -> std::same_as<uint64_t>;
};

template <class Exec>
concept TakesPositions = StagingRoom<typename Exec::Staging> &&
    requires(Exec& exec, const Exec& same, typename Exec::Staging& staging) {
  /// From any thread.
  { same.make_staging() } -> std::same_as<typename Exec::Staging>;
  /// What is in line so far is the last that reads what the staging brought.
  { exec.done_with(staging) } -> std::same_as<void>;
};

/// A backend.
template <class Exec>
concept Executor = OwnsMemory<Exec> && Copies<Exec> && RunsLoops<Exec> && Combines<Exec> && RunsFrames<Exec> &&
    TakesPositions<Exec> && requires(const Exec& exec) {
  { exec.device() } -> std::convertible_to<DeviceInfo>;
  /// Whether a verb takes its time even where there is nothing to do.
  { Exec::kLaunchesCost } -> std::convertible_to<bool>;
  /// Tells whether repeat() may be part of step().
  { Exec::kRecordsLoops } -> std::convertible_to<bool>;
};

// What a backend may provide besides.

/// A sort of its own for keys, faster than to count and place them: calls write(place, key, from) for the first `count`
/// keys in ascending order (KeyArrays).
template <class Exec>
concept SortsKeys = requires(Exec& exec, const char* name, const Counted& count, KeyArrays<probe::Write> arrays) {
  { exec.sort_keys(name, count, arrays) } -> std::same_as<void>;
};

}  // namespace collided
