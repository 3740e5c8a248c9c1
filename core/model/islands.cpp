#include "core/model/islands.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

namespace somas::model {

bool Islands::number(const Sites& sites, double distance, std::vector<std::uint32_t>& numbers) {
  const unsigned parts = team_ == nullptr ? 1 : team_->parts(sites.count());
  lay_out(sites, distance, parts);
  mark(sites, parts);
  list_runs();
  join_rows();
  const std::uint32_t islands = name_islands();
  if (islands < 2) return false;
  numbers.resize(sites.count());
  count_up(islands, numbers, parts);
  return true;
}

/// Of those that are somewhere.
Islands::Bounds Islands::bounds_of(const Sites& sites, Stretch own) {
  constexpr double nowhere = std::numeric_limits<double>::infinity(), absurd = 1e30;
  Bounds bounds{{nowhere, nowhere}, {-nowhere, -nowhere}};
  for (std::uint32_t i = own.begin; i < own.end; ++i) {
    const Two at{sites.x[i], sites.y[i]};
    if (!((std::abs(at[0]) < absurd) & (std::abs(at[1]) < absurd))) continue;
    bounds.low = at < bounds.low ? at : bounds.low;
    bounds.high = at > bounds.high ? at : bounds.high;
  }
  return bounds;
}

/// Bins so wide that who is nearer than the distance is in the same one or in one of the eight
/// round it.
void Islands::lay_out(const Sites& sites, double distance, unsigned parts) {
  bounds_.resize(parts);
  const auto look = [&](unsigned part) {
    bounds_[part] = bounds_of(sites, stretch(sites.count(), part, parts));
  };
  run_parts(team_, parts, look);
  Two low = bounds_[0].low, high = bounds_[0].high;
  for (const Bounds& some : bounds_) {
    low = some.low < low ? some.low : low;
    high = some.high > high ? some.high : high;
  }
  if (!(low[0] <= high[0])) low = high = Two{};
  low_ = low;
  const double width = high[0] - low[0], height = high[1] - low[1];
  // A body far off must not cost a grid as wide: a few bins a body are enough.
  const double most_bins = 4.0 * static_cast<double>(sites.count()) + 1024;
  const double side = (1 + 1e-9) * std::max({distance, std::max(width, height) / most_bins,
                                             std::sqrt(width * height / most_bins)});
  per_length_ = 1.0 / side;
  columns_ = static_cast<std::uint32_t>(width * per_length_) + 1;
  rows_ = static_cast<std::uint32_t>(height * per_length_) + 1;
  stride_ = columns_ + 1;
}

void Islands::mark(const Sites& sites, unsigned parts) {
  inhabited_.assign(std::size_t{stride_} * rows_, 0);
  bin_of_.resize(sites.count());
  const auto mark_some = [&](unsigned part) {
    const Stretch own = stretch(sites.count(), part, parts);
    for (std::uint32_t k = own.begin; k < own.end; ++k) {
      // What is nowhere, and near nobody, counts at an edge.
      const auto bin = [this](double from, std::uint32_t bins) {
        return static_cast<std::uint32_t>(std::min(from * per_length_, double(bins - 1)));
      };
      const Two way = sites[k] - low_;
      const std::uint32_t column = way[0] > 0 ? bin(way[0], columns_) : 0;
      const std::uint32_t row = way[1] > 0 ? bin(way[1], rows_) : 0;
      bin_of_[k] = row * stride_ + column;
      std::atomic_ref(inhabited_[bin_of_[k]]).store(1, std::memory_order_relaxed);
    }
  };
  run_parts(team_, parts, mark_some);
}

void Islands::list_runs() {
  runs_.clear();
  const std::uint8_t* const all = inhabited_.data();
  for (std::uint32_t row = 0; row < rows_; ++row) {
    const std::uint8_t* const begin = all + std::size_t{row} * stride_;
    const auto find = [&](std::uint32_t from, int what) {
      const void* at = std::memchr(begin + from, what, stride_ - from);
      return at == nullptr
                 ? stride_
                 : static_cast<std::uint32_t>(static_cast<const std::uint8_t*>(at) - begin);
    };
    for (std::uint32_t c = find(0, 1); c < stride_;) {
      const std::uint32_t end = find(c, 0);
      runs_.push_back({row, c, end, static_cast<std::uint32_t>(runs_.size())});
      c = find(end, 1);
    }
  }
}

/// Runs of a row touch those of the row before, at corners as well.
void Islands::join_rows() {
  std::uint32_t before = 0;
  for (std::uint32_t r = 0; r < runs_.size(); ++r) {
    const Run run = runs_[r];
    const auto is_over = [&](const Run& b) {
      return b.row + 1 < run.row || (b.row + 1 == run.row && b.end < run.begin);
    };
    while (is_over(runs_[before])) ++before;
    for (std::uint32_t b = before; runs_[b].row + 1 == run.row && runs_[b].begin <= run.end; ++b)
      join(b, r);
  }
}

std::uint32_t Islands::root(std::uint32_t run) {
  while (runs_[run].joined != run)
    run = runs_[run].joined = runs_[runs_[run].joined].joined;  // the way is halved
  return run;
}

void Islands::join(std::uint32_t one, std::uint32_t other) {
  const std::uint32_t a = root(one), b = root(other);
  runs_[std::max(a, b)].joined = std::min(a, b);
}

/// By the first of their runs; puts the names into the bins. Returns how many there are.
std::uint32_t Islands::name_islands() {
  std::uint32_t islands = 0;
  name_.resize(runs_.size());
  island_.resize(inhabited_.size());
  for (std::uint32_t r = 0; r < runs_.size(); ++r) {
    const std::uint32_t first = root(r);
    name_[r] = first == r ? islands++ : name_[first];
    std::uint32_t* const row = island_.data() + std::size_t{runs_[r].row} * stride_;
    std::fill(row + runs_[r].begin, row + runs_[r].end, name_[r]);
  }
  return islands;
}

/// A counting sort of the bodies by island.
void Islands::count_up(std::uint32_t islands, std::vector<std::uint32_t>& numbers, unsigned parts) {
  const auto bodies = static_cast<std::uint32_t>(numbers.size());
  counts_.reset(parts, islands);
  const auto count = [&](unsigned part) {
    const Stretch own = stretch(bodies, part, parts);
    std::uint32_t* counts = counts_.begin(part);
    for (std::uint32_t k = own.begin; k < own.end; ++k) {
      bin_of_[k] = island_[bin_of_[k]];
      ++counts[bin_of_[k]];
    }
  };
  run_parts(team_, parts, count);
  counts_.to_places(team_, start_);
  const auto place = [&](unsigned part) {
    const Stretch own = stretch(bodies, part, parts);
    std::uint32_t* places = counts_.of(part);
    for (std::uint32_t k = own.begin; k < own.end; ++k) numbers[k] = places[bin_of_[k]]++;
  };
  run_parts(team_, parts, place);
}

}  // namespace somas::model
