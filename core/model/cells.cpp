#include "core/model/cells.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/model/ranges.hpp"

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

namespace {

/// What is left of [0, ...) when some, ascending, leave.
class Remaining {
 public:
  explicit Remaining(std::span<const std::uint32_t> leavers) : leavers_(leavers) {}

  /// Calls add(first, count) for stretches that make up what is left from where it ended last, up
  /// to `end`.
  template <class Add>
  void until(std::uint32_t end, Add&& add) {
    for (; next_leaver_ < leavers_.size() && leavers_[next_leaver_] < end; ++next_leaver_) {
      add(next_, leavers_[next_leaver_] - next_);
      next_ = leavers_[next_leaver_] + 1;
    }
    add(next_, end - next_);
    next_ = end;
  }

 private:
  std::span<const std::uint32_t> leavers_;
  std::size_t next_leaver_ = 0;
  std::uint32_t next_ = 0;
};

/// The cells are sorted by organism and state.
void list_ranges(CellStore& cells) {
  cells.ranges.clear();
  const std::uint32_t count = cells.size();
  for (std::uint32_t begin = 0; begin < count;) {
    const std::pair key(cells.organism[begin], cells.state[begin]);
    std::uint32_t end = begin + 1, beyond = count;  // it ends in between
    while (end < beyond) {
      const std::uint32_t middle = end + (beyond - end) / 2;
      if (std::pair(cells.organism[middle], cells.state[middle]) == key)
        end = middle + 1;
      else
        beyond = middle;
    }
    cells.ranges.push_back({key.first, key.second, begin, end});
    begin = end;
  }
}

}  // namespace

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
  if (only_births_) {
    // Everybody else moves towards the back: in place, back to front, once these are set aside.
    auto* newborn = reinterpret_cast<T*>(scratch.data());
    std::copy(column + first_newborn_, column + count_, newborn);
    for (std::size_t r = runs_.size(); r-- > 0;) {
      const Run& run = runs_[r];
      if (run.from >= first_newborn_)
        std::copy_n(newborn + (run.from - first_newborn_), run.count, column + run.to);
      else
        std::memmove(column + run.to, column + run.from, run.count * sizeof(T));
    }
    return;
  }
  const std::size_t first = runs_.front().to;
  auto* moved = reinterpret_cast<T*>(scratch.data());
  for (const Run& run : runs_)
    std::memcpy(moved + (run.to - first), column + run.from, run.count * sizeof(T));
  std::memcpy(column + first, moved, (count_ - first) * sizeof(T));
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

  const unsigned parts = team_ == nullptr ? 1 : team_->parts(count_);
  scratch_.resize(std::max<std::size_t>(scratch_.size(), parts));
  for (auto& scratch : scratch_)
    scratch.resize(std::max(scratch.size(), count_ * sizeof(std::uint64_t)));
  // Wide columns come first and narrow ones last: deal them out in turn.
  const auto gather_some = [&](unsigned part) {
    for (std::size_t m = part; m < moves_.size(); m += parts)
      moves_[m].gather(*this, moves_[m].column, scratch_[part]);
  };
  if (parts == 1) return gather_some(0);
  team_->run(parts, gather_some);
}

void Reorganiser::run(CellStore& cells, std::span<const std::uint8_t> remove) {
  const bool ordered = !cells.ranges.empty();
  first_newborn_ = ordered ? cells.ranges.back().end : 0;
  list_changes(cells, remove);
  list_runs(cells);
  list_new_index(cells.size());
  if (!ordered) cells.order.clear();
  follow_order(cells);
  gather_columns(cells);
  cells.each_column([&](auto& column) { column.resize(count_); });
  list_ranges(cells);
}

/// Who leaves its place; of these and the newborn, those that go to another, in order.
void Reorganiser::list_changes(const CellStore& cells, std::span<const std::uint8_t> remove) {
  leavers_.clear();
  moved_.clear();
  const auto remains = [&](std::uint32_t i) { return remove.empty() || remove[i] == 0; };
  // Few leave: look at many at a time.
  constexpr std::uint32_t many = 64;
  for (const CellRange& range : cells.ranges)
    for (std::uint32_t begin = range.begin; begin < range.end; begin += many) {
      const std::uint32_t end = std::min(begin + many, range.end);
      std::uint32_t any = 0;
      for (std::uint32_t i = begin; i < end; ++i) any |= cells.state[i] ^ range.state;
      if (!remove.empty())
        for (std::uint32_t i = begin; i < end; ++i) any |= remove[i];
      for (std::uint32_t i = begin; any != 0 && i < end; ++i) {
        const bool changed = cells.state[i] != range.state;
        if (changed || !remains(i)) leavers_.push_back(i);
        if (changed && remains(i)) moved_.push_back(i);
      }
    }
  for (std::uint32_t i = first_newborn_; i < cells.size(); ++i)
    if (remains(i)) moved_.push_back(i);
  only_removals_ = moved_.empty();
  only_births_ = leavers_.empty() && moved_.size() == cells.size() - first_newborn_;
  const auto key = [&](std::uint32_t i) {
    return std::tuple(cells.organism[i], cells.state[i], cells.id[i]);
  };
  std::sort(moved_.begin(), moved_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
}

/// The first of the cells in ranges that come after `cell`.
std::uint32_t Reorganiser::place_of(const CellStore& cells, std::uint32_t cell) const {
  const std::pair key(cells.organism[cell], cells.state[cell]);
  const auto range = std::ranges::lower_bound(
      cells.ranges, key, {}, [](const CellRange& r) { return std::pair(r.organism, r.state); });
  if (range == cells.ranges.end()) return first_newborn_;
  if (std::pair(range->organism, range->state) != key) return range->begin;
  const auto ids = cells.id.begin();
  return static_cast<std::uint32_t>(
      std::lower_bound(ids + range->begin, ids + range->end, cells.id[cell]) - ids);
}

/// Those that stay, cell by cell as they stood, and in between those that move.
void Reorganiser::list_runs(const CellStore& cells) {
  runs_.clear();
  count_ = 0;
  const auto add = [this](std::uint32_t from, std::uint32_t count) {
    const bool in_place = runs_.empty() && from == count_;
    const bool longer = !runs_.empty() && runs_.back().from + runs_.back().count == from;
    if (longer) runs_.back().count += count;
    if (!longer && !in_place && count > 0) runs_.push_back({count_, from, count});
    count_ += count;
  };
  Remaining remaining(leavers_);
  for (const std::uint32_t i : moved_) {
    remaining.until(place_of(cells, i), add);
    add(i, 1);
  }
  remaining.until(first_newborn_, add);
}

void Reorganiser::list_new_index(std::uint32_t old_count) {
  new_index_.resize(old_count);
  const auto at = new_index_.begin();
  for (const std::uint32_t i : leavers_) new_index_[i] = gone;
  std::fill(at + first_newborn_, new_index_.end(), gone);
  std::iota(at, at + (runs_.empty() ? count_ : runs_.front().to), 0u);
  for (const Run& run : runs_) std::iota(at + run.from, at + run.from + run.count, run.to);
}

/// Whoever was in the order keeps it; the newborn have the highest ids of their organism.
void Reorganiser::follow_order(CellStore& cells) {
  const auto old_count = static_cast<std::uint32_t>(cells.order.size());
  list_lost_ranks(cells);
  for (std::uint32_t i = old_count; i < cells.size(); ++i)
    if (new_index_[i] != gone) cells.order.push_back(i);
  const auto key = [&](std::uint32_t i) { return std::pair(cells.organism[i], cells.id[i]); };
  std::sort(cells.order.begin() + old_count, cells.order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });

  order_runs_.clear();
  std::uint32_t to = 0;
  const auto add = [&](std::uint32_t from, std::uint32_t count) {
    if (count > 0) order_runs_.push_back({to, from, count});
    to += count;
  };
  Remaining remaining(lost_ranks_);
  for (std::uint32_t k = old_count; k < cells.order.size(); ++k) {
    // Cells of an organism stand together, in storage as in this order.
    const std::uint16_t organism = cells.organism[cells.order[k]];
    const auto later = std::ranges::upper_bound(cells.ranges, organism, {}, &CellRange::organism);
    remaining.until(later == cells.ranges.end() ? old_count : later->begin, add);
    add(k, 1);
  }
  remaining.until(old_count, add);

  next_order_.resize(count_);
  cells.rank.resize(count_);
  share(team_, count_, [&](std::uint32_t begin, std::uint32_t end) {
    if (begin == end) return;
    auto run = std::ranges::upper_bound(order_runs_, begin, {}, &Run::to) - 1;
    for (std::uint32_t k = begin; k < end; ++run)
      for (const std::uint32_t beyond = std::min(run->to + run->count, end); k < beyond; ++k) {
        const std::uint32_t i = new_index_[cells.order[run->from + (k - run->to)]];
        next_order_[k] = i;
        cells.rank[i] = k;
      }
  });
  cells.order.swap(next_order_);
}

/// Places in canonical order of those that are gone.
void Reorganiser::list_lost_ranks(const CellStore& cells) {
  lost_ranks_.clear();
  for (const std::uint32_t i : leavers_)
    if (new_index_[i] == gone) lost_ranks_.push_back(cells.rank[i]);
  std::sort(lost_ranks_.begin(), lost_ranks_.end());
}

}  // namespace somas::model
