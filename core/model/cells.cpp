#include "core/model/cells.hpp"

#include <algorithm>
#include <array>
#include <cstring>
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

/// Of a part: cells that stay where they are in an order, or come before it; and others.
struct Count {
  std::uint32_t kept = 0, others = 0;
};
constexpr unsigned most_parts = 64;

unsigned parts_of(const Team* team, std::uint32_t count) {
  return team == nullptr ? 1 : std::min(team->parts(count), most_parts);
}

/// Calls work(part, begin, end) for so many parts of [0, count), at once.
template <class Work>
void share_parts(Team* team, std::uint32_t count, unsigned parts, const Work& work) {
  if (parts == 1) return work(0u, 0u, count);
  const auto part_of = [&](unsigned part) {
    const Stretch own = stretch(count, part, parts);
    work(part, own.begin, own.end);
  };
  team->run(parts, part_of);
}

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
    std::copy(column + first_newborn_, column + source_.size(), newborn);
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
  const auto count = static_cast<std::uint32_t>(source_.size());
  new_index_.assign(old_count, gone);
  share(team_, count, [this](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) new_index_[source_[i]] = i;
  });
  if (ordered)
    follow_order(cells);
  else
    sort_order(cells);

  list_runs();
  gather_columns(cells);
  cells.each_column([&](auto& column) { column.resize(source_.size()); });

  list_ranges(cells);
  cells.order.swap(next_order_);
  cells.rank.resize(count);
  share(team_, count, [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) cells.rank[cells.order[k]] = k;
  });
}

void Reorganiser::sort(const CellStore& cells, std::span<const std::uint8_t> remove) {
  const auto key = [&](std::uint32_t i) {
    return std::tuple(cells.organism[i], cells.state[i], cells.id[i]);
  };
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); };
  const auto stays = [&](std::uint32_t i) { return remove.empty() || remove[i] == 0; };

  // Survivors still of their range's state stand in order; the others (newborn, specialized) are
  // few: they are sorted and put between.
  const std::uint32_t ranged = cells.ranges.empty() ? 0 : cells.ranges.back().end;
  const unsigned parts = parts_of(team_, ranged);
  std::array<Count, most_parts> counts{};
  share_parts(team_, ranged, parts, [&](unsigned part, std::uint32_t begin, std::uint32_t end) {
    each_range(cells, begin, end, [&](const CellRange& range) {
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const bool same = cells.state[i] == range.state;
        counts[part].kept += stays(i) & same ? 1 : 0;
        counts[part].others += stays(i) & !same ? 1 : 0;
      }
    });
  });
  moved_.clear();
  std::uint32_t kept = 0;
  for (unsigned part = 0; part < parts; ++part) {
    const Stretch own = stretch(ranged, part, parts);
    kept += std::exchange(counts[part].kept, kept);
    if (counts[part].others == 0) continue;
    each_range(cells, own.begin, own.end, [&](const CellRange& range) {
      for (std::uint32_t i = range.begin; i < range.end; ++i)
        if (stays(i) && cells.state[i] != range.state) moved_.push_back(i);
    });
  }
  for (std::uint32_t i = ranged; i < cells.size(); ++i)
    if (stays(i)) moved_.push_back(i);

  kept_.resize(kept);
  share_parts(team_, ranged, parts, [&](unsigned part, std::uint32_t begin, std::uint32_t end) {
    std::uint32_t to = counts[part].kept;
    const std::uint32_t last = part + 1 < parts ? counts[part + 1].kept : kept;
    each_range(cells, begin, end, [&](const CellRange& range) {
      for (std::uint32_t i = range.begin; i < range.end && to < last; ++i) {
        kept_[to] = i;
        to += stays(i) & (cells.state[i] == range.state) ? 1 : 0;
      }
    });
  });

  only_removals_ = moved_.empty();
  first_newborn_ = ranged;
  only_births_ = kept == ranged && moved_.size() == cells.size() - ranged;
  if (only_removals_) return source_.swap(kept_);
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
}

void Reorganiser::follow_order(const CellStore& cells) {
  // Whoever was there keeps the order; the newborn have the highest ids of their organism.
  const auto old_count = static_cast<std::uint32_t>(cells.order.size());
  newborn_.clear();
  for (std::uint32_t i = old_count; i < cells.size(); ++i)
    if (new_index_[i] != gone) newborn_.push_back(i);
  std::sort(newborn_.begin(), newborn_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(cells.organism[a], cells.id[a]) < std::tuple(cells.organism[b], cells.id[b]);
  });
  next_order_.resize(source_.size());
  const unsigned parts = parts_of(team_, old_count);
  std::array<Count, most_parts> counts{};
  if (parts > 1)
    share_parts(team_, old_count, parts,
                [&](unsigned part, std::uint32_t begin, std::uint32_t end) {
                  for (std::uint32_t k = begin; k < end; ++k)
                    counts[part].kept += new_index_[cells.order[k]] != gone ? 1 : 0;
                });
  std::uint32_t kept = 0;
  for (unsigned part = 0; part < parts; ++part) kept += std::exchange(counts[part].kept, kept);

  share_parts(team_, old_count, parts, [&](unsigned part, std::uint32_t begin, std::uint32_t end) {
    // The newborn of an organism come before the first cell of a later one.
    std::size_t newborn = 0;
    const auto insert = [&](std::uint32_t& to, std::uint32_t below) {
      for (; newborn < newborn_.size() && cells.organism[newborn_[newborn]] < below; ++newborn)
        next_order_[to++] = new_index_[newborn_[newborn]];
    };
    if (begin > 0)
      while (newborn < newborn_.size() &&
             cells.organism[newborn_[newborn]] < cells.organism[cells.order[begin - 1]])
        ++newborn;
    std::uint32_t to = counts[part].kept + static_cast<std::uint32_t>(newborn);
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t i = cells.order[k];
      insert(to, cells.organism[i]);
      if (new_index_[i] != gone) next_order_[to++] = new_index_[i];
    }
    if (part + 1 == parts) insert(to, gone);
  });
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
