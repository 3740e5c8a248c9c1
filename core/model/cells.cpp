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
void Reorganiser::gather(std::vector<T>& column) {
  static_assert(sizeof(T) <= sizeof(std::uint64_t) && std::is_trivially_copyable_v<T>);
  for (std::size_t i = 0; i < source_.size(); ++i)
    std::memcpy(scratch_.data() + i * sizeof(T), &column[source_[i]], sizeof(T));
  column.resize(source_.size());
  std::memcpy(column.data(), scratch_.data(), source_.size() * sizeof(T));
}

void Reorganiser::run(CellStore& cells, std::span<const std::uint8_t> remove) {
  const std::uint32_t old_count = cells.size();
  const auto key = [&](std::uint32_t i) {
    return std::tuple(cells.organism[i], cells.state[i], cells.id[i]);
  };
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); };

  // Survivors still of their range's state stand in order; the others (newborn, specialized) are
  // sorted and merged in.
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
  for (std::uint32_t i = ranged; i < old_count; ++i)
    if (remove.empty() || remove[i] == 0) moved_.push_back(i);
  std::sort(moved_.begin(), moved_.end(), before);
  source_.resize(kept_.size() + moved_.size());
  std::merge(kept_.begin(), kept_.end(), moved_.begin(), moved_.end(), source_.begin(), before);

  new_index_.assign(old_count, gone);
  for (std::uint32_t i = 0; i < source_.size(); ++i) new_index_[source_[i]] = i;

  scratch_.resize(std::max(scratch_.size(), source_.size() * sizeof(std::uint64_t)));
  cells.each_column([&](auto& column) { gather(column); });
  for (std::uint32_t c = 0; c < cells.memory.channels(); ++c) {
    float* row = cells.memory.row(c);
    for (std::size_t i = 0; i < source_.size(); ++i)
      std::memcpy(scratch_.data() + i * sizeof(float), row + source_[i], sizeof(float));
    std::memcpy(row, scratch_.data(), source_.size() * sizeof(float));
  }

  // Ranges of equal (organism, state), and the canonical order within each organism.
  const std::uint32_t count = cells.size();
  cells.ranges.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    if (cells.ranges.empty() || cells.ranges.back().organism != cells.organism[i] ||
        cells.ranges.back().state != cells.state[i])
      cells.ranges.push_back({cells.organism[i], cells.state[i], i, i});
    cells.ranges.back().end = i + 1;
  }
  cells.order.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) cells.order[i] = i;
  const auto canonical = [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(cells.organism[a], cells.id[a]) < std::tuple(cells.organism[b], cells.id[b]);
  };
  for (std::size_t r = 1; r < cells.ranges.size(); ++r) {
    // Ranges of an organism are sorted by id already: merge each into those before it.
    if (cells.ranges[r].organism != cells.ranges[r - 1].organism) continue;
    std::size_t first = r;
    while (first > 0 && cells.ranges[first - 1].organism == cells.ranges[r].organism) --first;
    const auto at = [&](std::uint32_t i) { return cells.order.begin() + i; };
    merged_.resize(cells.ranges[r].end - cells.ranges[first].begin);
    std::merge(at(cells.ranges[first].begin), at(cells.ranges[r].begin), at(cells.ranges[r].begin),
               at(cells.ranges[r].end), merged_.begin(), canonical);
    std::copy(merged_.begin(), merged_.end(), at(cells.ranges[first].begin));
  }
  cells.rank.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) cells.rank[cells.order[i]] = i;
}

}  // namespace somas::model
