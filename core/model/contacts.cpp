#include "core/model/cells.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

void Contacts::remap(std::span<const std::uint32_t> new_index) {
  // Removal keeps the order of what stays, so lists are compacted in place.
  std::uint32_t kept_cells = 0, kept_items = 0;
  for (std::uint32_t i = 0; i + 1 < start.size(); ++i) {
    const std::uint32_t begin = start[i], end = start[i + 1];
    if (new_index[i] == gone) continue;
    start[kept_cells++] = kept_items;
    for (std::uint32_t k = begin; k < end; ++k)
      if (new_index[items[k]] != gone) items[kept_items++] = new_index[items[k]];
  }
  start.resize(kept_cells + 1);
  start[kept_cells] = kept_items;
  items.resize(kept_items);
}

}  // namespace somas::model
