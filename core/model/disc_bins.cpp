#include "core/model/disc_bins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace somas::model {

namespace {

bool is_somewhere(const Disc& disc) {
  constexpr double absurd = 1e30;
  return (std::abs(disc.x) < absurd) & (std::abs(disc.y) < absurd);
}

}  // namespace

DiscBins::Bounds DiscBins::bounds_of(std::span<const Disc> discs) {
  constexpr double nowhere = std::numeric_limits<double>::infinity();
  Bounds bounds{{nowhere, nowhere}, {-nowhere, -nowhere}, 0, 0};
  for (const Disc& disc : discs) {
    bounds.radius = std::max(bounds.radius, disc.radius);
    bounds.margin = std::max(bounds.margin, disc.margin);
    if (!is_somewhere(disc)) continue;
    const Two at{disc.x, disc.y};
    bounds.low = at < bounds.low ? at : bounds.low;
    bounds.high = at > bounds.high ? at : bounds.high;
  }
  return bounds;
}

DiscBins::Bounds DiscBins::bounds_of(std::span<const Disc> discs, unsigned parts) {
  if (parts == 1) return bounds_of(discs);
  bounds_.resize(std::max<std::size_t>(bounds_.size(), parts));
  const auto look = [&](unsigned part) {
    const Stretch own = stretch(static_cast<std::uint32_t>(discs.size()), part, parts);
    bounds_[part] = bounds_of(discs.subspan(own.begin, own.end - own.begin));
  };
  team_->run(parts, look);
  Bounds all = bounds_[0];
  for (const Bounds& some : std::span(bounds_).first(parts)) {
    all.radius = std::max(all.radius, some.radius);
    all.margin = std::max(all.margin, some.margin);
    all.low = some.low < all.low ? some.low : all.low;
    all.high = some.high > all.high ? some.high : all.high;
  }
  return all;
}

void DiscBins::lay_out(const Bounds& bounds, std::size_t count, double range) {
  Two low = bounds.low, high = bounds.high;
  if (!(low[0] <= high[0])) low = high = Two{};
  left_ = low[0];
  bottom_ = low[1];
  widest_ = bounds.radius * range + bounds.margin;
  const double width = high[0] - low[0], height = high[1] - low[1];
  // A disc far off must not cost a grid as wide: a few bins a disc are enough.
  const double most_bins = 4.0 * static_cast<double>(count) + 1024;
  side_ = (1 + 1e-9) * std::max({2.0 * widest_, std::max(width, height) / most_bins,
                                 std::sqrt(width * height / most_bins)});
  columns_ = static_cast<std::uint32_t>(width / side_) + 2;
  rows_ = static_cast<std::uint32_t>(height / side_) + 2;
  coarse_ = rounding * std::max(width, height) > coarse_error;
}

inline std::uint32_t DiscBins::bin_of(const Disc& disc) const {
  const bool somewhere = is_somewhere(disc);
  const double x = somewhere ? disc.x - left_ : 0.0;
  const double y = somewhere ? disc.y - bottom_ : 0.0;
  const auto column = static_cast<std::int32_t>(x * per_length_);
  const auto row = static_cast<std::int32_t>(y * per_length_);
  return static_cast<std::uint32_t>(row) * columns_ + static_cast<std::uint32_t>(column);
}

inline void DiscBins::put(std::uint32_t item, const Disc& disc, double range, double error,
                          std::uint32_t at) {
  const double reach = range * disc.radius + disc.margin;
  items_[at] = item;
  bin_at_[at] = bin_of_[item];
  x_[at] = static_cast<float>(disc.x - left_);
  y_[at] = static_cast<float>(disc.y - bottom_);
  reach_[at] = static_cast<float>(reach * (1 + 4 * rounding) + error);
}

void DiscBins::sort(std::span<const Disc> discs, double range) {
  const std::size_t count = discs.size();
  const unsigned parts = team_ == nullptr ? 1 : team_->parts(count);
  lay_out(bounds_of(discs, parts), count, range);
  per_length_ = 1.0 / side_;
  const double error = rounding * side_ * (columns_ + rows_);
  bin_of_.resize(count);
  bin_at_.resize(count);
  items_.resize(count + 8);
  for (auto* column : {&x_, &y_, &reach_}) column->resize(count + 8);
  if (parts > 1) return sort_in_parts(discs, range, error, parts);
  // A counting sort. Counts stand two places on, so that places taken one on leave the starts.
  start_.assign(static_cast<std::size_t>(columns_) * rows_ + 2, 0);
  for (std::size_t i = 0; i < count; ++i) {
    bin_of_[i] = bin_of(discs[i]);
    ++start_[bin_of_[i] + 2];
  }
  for (std::size_t b = 2; b < start_.size(); ++b) start_[b] += start_[b - 1];
  for (std::uint32_t i = 0; i < count; ++i)
    put(i, discs[i], range, error, start_[bin_of_[i] + 1]++);
}

/// Bins that follow each other are one part's: it alone puts discs there, those that the parts have
/// dealt to it, one part's after another's. (There may be many more bins than discs: that every
/// part counts by all of them, as PartedCounts does, would take longer than all the rest.)
void DiscBins::sort_in_parts(std::span<const Disc> discs, double range, double error,
                             unsigned parts) {
  const auto count = static_cast<std::uint32_t>(discs.size());
  const std::uint64_t bins = std::uint64_t{columns_} * rows_;
  const std::uint64_t per_bin = (std::uint64_t{parts} << 32) / bins;
  const auto first_bin = [&](std::uint64_t part) {
    return std::min(bins, ((part << 32) + per_bin - 1) / per_bin);
  };
  start_.resize(bins + 2);
  dealt_.resize(count);
  // A line of the cache for each part at least.
  const std::size_t stride = (parts + 2 + 15) / 16 * 16;
  dealt_start_.assign(parts * stride, 0);

  // Counts stand two places on, as above.
  const auto deal = [&](unsigned part) {
    const Stretch own = stretch(count, part, parts);
    std::uint32_t* start = &dealt_start_[part * stride];
    for (std::uint32_t i = own.begin; i < own.end; ++i) {
      bin_of_[i] = bin_of(discs[i]);
      ++start[(bin_of_[i] * per_bin >> 32) + 2];
    }
    start[0] = start[1] = own.begin;
    for (unsigned p = 2; p < parts + 2; ++p) start[p] += start[p - 1];
    for (std::uint32_t i = own.begin; i < own.end; ++i)
      dealt_[start[(bin_of_[i] * per_bin >> 32) + 1]++] = i;
  };
  team_->run(parts, deal);

  const auto place = [&](unsigned part) {
    const std::uint64_t begin = first_bin(part),
                        end = part + 1 < parts ? first_bin(part + 1) : bins;
    const auto each_disc = [&](auto&& visit) {
      for (unsigned from = 0; from < parts; ++from) {
        const std::uint32_t* start = &dealt_start_[from * stride];
        for (std::uint32_t k = start[part]; k < start[part + 1]; ++k) visit(dealt_[k]);
      }
    };
    std::uint32_t next = 0;
    for (unsigned from = 0; from < parts; ++from)
      next += dealt_start_[from * stride + part] - dealt_start_[from * stride];
    // The counts of a part stand one place on, so that they are in nobody else's way.
    std::uint32_t* const place_of = start_.data() + 1;
    std::fill(place_of + begin, place_of + end, 0u);
    each_disc([&](std::uint32_t i) { ++place_of[bin_of_[i]]; });
    for (std::uint64_t b = begin; b < end; ++b) next += std::exchange(place_of[b], next);
    each_disc([&](std::uint32_t i) { put(i, discs[i], range, error, place_of[bin_of_[i]]++); });
  };
  team_->run(parts, place);
  start_.front() = 0;
}

}  // namespace somas::model
