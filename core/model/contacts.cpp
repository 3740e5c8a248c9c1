#include "core/model/cells.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

void Contacts::remap(std::span<const std::uint32_t> new_index) {
  // Removal keeps the order of the cells that stay. Runs keep their places, and get shorter.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (new_index[i] == gone) continue;
    Run run{runs[i].begin, runs[i].begin};
    for (const std::uint32_t other : of(static_cast<std::uint32_t>(i)))
      if (new_index[other] != gone) items[run.end++] = new_index[other];
    runs[kept++] = run;
  }
  runs.resize(kept);
}

}  // namespace somas::model
