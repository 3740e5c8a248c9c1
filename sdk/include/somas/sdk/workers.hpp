/// @file
/// Work that an environment or a fitness shares with the threads of a large world.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <type_traits>

#include "somas/sdk/extension.hpp"
#include "somas/sdk/world.hpp"

namespace somas {

/// The threads of a world: an extension of World. A host that is asked for one thread has it, too,
/// and does all work in the thread of the call.
class Workers {
 public:
  /// What a host answers to.
  static constexpr std::string_view extension_id = "somas.workers/1";
  /// Does the items [begin, end) of some work.
  using Call = void (*)(void* context, std::uint32_t begin, std::uint32_t end);
  /// Calls call(context, begin, end) for parts that make up [0, count), perhaps at once and in any
  /// order, and returns when all have ended. Parts have `least` items at least, unless there are
  /// fewer in all; how many there are hangs on the machine, so no result may. What a part throws
  /// ends the rest only when it likes; of several exceptions that of the lowest part is thrown on.
  /// From the call of the plugin that was handed the world, and never from within a part.
  virtual void share(std::uint32_t count, std::uint32_t least, Call call, void* context) = 0;
  /// So many parts at most are done at once: 1 where nobody helps.
  [[nodiscard]] virtual std::uint32_t threads() const = 0;

 protected:
  ~Workers() = default;
};

/// Calls work(begin, end) for parts that make up [0, count), at once where the host has threads for
/// this world (`--world-threads`), else once for all. Parts must not touch what others write, and
/// must not call the world: take its columns and grids before. Nothing may hang on where parts
/// begin and end: neither sums nor chance. `least`: items that take some 20 microseconds; fewer are
/// not worth a thread. Throws what the lowest part threw.
template <class Work>
void share_work(World& world, std::uint32_t count, std::uint32_t least, Work&& work) {
  Workers* const workers = extension_of<Workers>(world);
  if (workers == nullptr) {
    if (count > 0) work(std::uint32_t{0}, count);
    return;
  }
  using Plain = std::remove_reference_t<Work>;
  const auto call = [](void* context, std::uint32_t begin, std::uint32_t end) {
    (*static_cast<Plain*>(context))(begin, end);
  };
  workers->share(count, least, call,
                 const_cast<void*>(static_cast<const void*>(std::addressof(work))));
}

/// So many threads share the work of this world: what scratch memory there may be use for.
[[nodiscard]] inline std::uint32_t threads_of(const World& world) {
  const Workers* const workers = extension_of<Workers>(world);
  return workers == nullptr ? 1 : workers->threads();
}

}  // namespace somas
