#include "core/model/cells.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace somas::model {

void FloatMatrix::reshape(std::uint32_t channels, std::uint32_t lanes) {
  if (channels == channels_ && lanes <= stride_) return;
  std::size_t stride = std::max<std::size_t>(stride_, 64);
  while (stride < lanes) stride *= 2;
  std::vector<float> data(stride * channels, 0.0f);
  for (std::uint32_t c = 0; c < std::min(channels, channels_); ++c)
    std::copy_n(row(c), stride_, data.data() + c * stride);
  data_ = std::move(data);
  stride_ = stride;
  channels_ = channels;
}

std::uint32_t CellStore::append(std::uint32_t memory_rows) {
  const std::uint32_t index = size();
  each_column([](auto& column) { column.emplace_back(); });
  cause.back() = no_cause;
  memory.reshape(std::max(memory_rows, memory.channels()), index + 1);
  for (std::uint32_t c = 0; c < memory.channels(); ++c) memory.row(c)[index] = 0.0f;
  return index;
}

void CellStore::copy_cell(std::uint32_t from, std::uint32_t to) {
  each_column([&](auto& column) { column[to] = column[from]; });
  for (std::uint32_t c = 0; c < memory.channels(); ++c) memory.row(c)[to] = memory.row(c)[from];
}

template <class T>
void Reorganiser::gather(T* column, std::vector<std::byte>& scratch) const {
  static_assert(sizeof(T) <= sizeof(std::uint64_t) && std::is_trivially_copyable_v<T>);
  if (only_removals_) {
    // Everybody moves towards the front: in place, front to back.
    for (const Run& run : runs_)
      std::memmove(column + run.to, column + run.from, run.count * sizeof(T));
    return;
  }
  if (runs_.empty()) return;
  const std::size_t first = runs_.front().to;
  auto* moved = reinterpret_cast<T*>(scratch.data());
  for (const Run& run : runs_)
    std::memcpy(moved + (run.to - first), column + run.from, run.count * sizeof(T));
  std::memcpy(column + first, moved, (source_.size() - first) * sizeof(T));
}

void Reorganiser::gather_columns(CellStore& cells) {
  moves_.clear();
  const auto add = [&]<class T>(T* column) {
    moves_.push_back(
        {column, [](const Reorganiser& how, void* of, std::vector<std::byte>& scratch) {
           how.gather(static_cast<T*>(of), scratch);
         }});
  };
  cells.each_column([&](auto& column) { add(column.data()); });
  for (std::uint32_t c = 0; c < cells.memory.channels(); ++c) add(cells.memory.row(c));

  const unsigned parts = team_ == nullptr ? 1 : team_->parts(source_.size());
  scratch_.resize(std::max<std::size_t>(scratch_.size(), parts));
  for (auto& scratch : scratch_)
    scratch.resize(std::max(scratch.size(), source_.size() * sizeof(std::uint64_t)));
  // Wide columns come first and narrow ones last: deal them out in turn.
  const auto gather_some = [&](unsigned part) {
    for (std::size_t m = part; m < moves_.size(); m += parts)
      moves_[m].gather(*this, moves_[m].column, scratch_[part]);
  };
  if (parts == 1) return gather_some(0);
  team_->run(parts, gather_some);
}

void Reorganiser::list_runs() {
  runs_.clear();
  std::uint32_t i = 0;
  while (i < source_.size() && source_[i] == i) ++i;
  for (; i < source_.size(); ++i) {
    if (runs_.empty() || source_[i] != source_[i - 1] + 1) runs_.push_back({i, source_[i], 0});
    ++runs_.back().count;
  }
}

void Reorganiser::run(CellStore& cells, std::span<const std::uint8_t> remove) {
  const std::uint32_t old_count = cells.size();
  const bool ordered = !cells.ranges.empty();
  sort(cells, remove);
  new_index_.assign(old_count, gone);
  for (std::uint32_t i = 0; i < source_.size(); ++i) new_index_[source_[i]] = i;
  if (ordered)
    follow_order(cells);
  else
    sort_order(cells);

  list_runs();
  gather_columns(cells);
  cells.each_column([&](auto& column) { column.resize(source_.size()); });

  cells.ranges.clear();
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (cells.ranges.empty() || cells.ranges.back().organism != cells.organism[i] ||
        cells.ranges.back().state != cells.state[i])
      cells.ranges.push_back({cells.organism[i], cells.state[i], i, i});
    cells.ranges.back().end = i + 1;
  }
  cells.order.swap(next_order_);
  cells.rank.resize(cells.size());
  for (std::uint32_t k = 0; k < cells.size(); ++k) cells.rank[cells.order[k]] = k;
}

void Reorganiser::sort(const CellStore& cells, std::span<const std::uint8_t> remove) {
  const auto key = [&](std::uint32_t i) {
    return std::tuple(cells.organism[i], cells.state[i], cells.id[i]);
  };
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); };

  // Survivors still of their range's state stand in order; the others (newborn, specialized) are
  // few: they are sorted and put between.
  kept_.clear();
  moved_.clear();
  std::uint32_t ranged = 0;
  for (const CellRange& range : cells.ranges) {
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      if (!remove.empty() && remove[i] != 0) continue;
      (cells.state[i] == range.state ? kept_ : moved_).push_back(i);
    }
    ranged = range.end;
  }
  for (std::uint32_t i = ranged; i < cells.size(); ++i)
    if (remove.empty() || remove[i] == 0) moved_.push_back(i);
  std::sort(moved_.begin(), moved_.end(), before);
  source_.clear();
  auto from = kept_.begin();
  for (const std::uint32_t i : moved_) {
    const auto to = std::lower_bound(from, kept_.end(), i, before);
    source_.insert(source_.end(), from, to);
    source_.push_back(i);
    from = to;
  }
  source_.insert(source_.end(), from, kept_.end());
  only_removals_ = moved_.empty();
}

void Reorganiser::follow_order(const CellStore& cells) {
  // Whoever was there keeps the order; the newborn have the highest ids of their organism.
  newborn_.clear();
  for (std::uint32_t i = static_cast<std::uint32_t>(cells.order.size()); i < cells.size(); ++i)
    if (new_index_[i] != gone) newborn_.push_back(i);
  std::sort(newborn_.begin(), newborn_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(cells.organism[a], cells.id[a]) < std::tuple(cells.organism[b], cells.id[b]);
  });
  next_order_.clear();
  auto newborn = newborn_.begin();
  for (const std::uint32_t i : cells.order) {
    for (; newborn != newborn_.end() && cells.organism[*newborn] < cells.organism[i]; ++newborn)
      next_order_.push_back(new_index_[*newborn]);
    if (new_index_[i] != gone) next_order_.push_back(new_index_[i]);
  }
  for (; newborn != newborn_.end(); ++newborn) next_order_.push_back(new_index_[*newborn]);
}

void Reorganiser::sort_order(const CellStore& cells) {
  std::vector<std::uint32_t> canonical = source_;
  std::sort(canonical.begin(), canonical.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(cells.organism[a], cells.id[a]) < std::tuple(cells.organism[b], cells.id[b]);
  });
  next_order_.clear();
  for (const std::uint32_t i : canonical) next_order_.push_back(new_index_[i]);
}

}  // namespace somas::model
