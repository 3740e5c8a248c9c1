#include "core/model/disc_bins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

/// A seeming reach wider by more than this lets too many pass.
constexpr double coarse_error = 0.01;

bool is_somewhere(const Disc& disc) {
  constexpr double absurd = 1e30;
  return (std::abs(disc.x) < absurd) & (std::abs(disc.y) < absurd);
}

}  // namespace

void DiscBins::lay_out(std::span<const Disc> discs, double range) {
  constexpr double nowhere = std::numeric_limits<double>::infinity();
  Two low{nowhere, nowhere}, high{-nowhere, -nowhere};
  double radius = 0, margin = 0;
  for (const Disc& disc : discs) {
    radius = std::max(radius, disc.radius);
    margin = std::max(margin, disc.margin);
    if (!is_somewhere(disc)) continue;
    const Two at{disc.x, disc.y};
    low = at < low ? at : low;
    high = at > high ? at : high;
  }
  if (!(low[0] <= high[0])) low = high = Two{};
  left_ = low[0];
  bottom_ = low[1];
  widest_ = radius * range + margin;
  const double width = high[0] - low[0], height = high[1] - low[1];
  // A disc far off must not cost a grid as wide: a few bins a disc are enough.
  const double most_bins = 4.0 * static_cast<double>(discs.size()) + 1024;
  side_ = (1 + 1e-9) * std::max({2.0 * widest_, std::max(width, height) / most_bins,
                                 std::sqrt(width * height / most_bins)});
  columns_ = static_cast<std::uint32_t>(width / side_) + 1;
  rows_ = static_cast<std::uint32_t>(height / side_) + 1;
  coarse_ = rounding * std::max(width, height) > coarse_error;
}

void DiscBins::sort(std::span<const Disc> discs, double range) {
  lay_out(discs, range);
  const std::size_t count = discs.size();
  const double bins_per_length = 1.0 / side_;
  const double error = rounding * side_ * (columns_ + rows_);
  // A counting sort. Counts stand two places on, so that places taken one on leave the starts.
  bin_of_.resize(count);
  start_.assign(static_cast<std::size_t>(columns_) * rows_ + 2, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const bool somewhere = is_somewhere(discs[i]);
    const double x = somewhere ? discs[i].x - left_ : 0.0;
    const double y = somewhere ? discs[i].y - bottom_ : 0.0;
    const auto column = static_cast<std::int32_t>(x * bins_per_length);
    const auto row = static_cast<std::int32_t>(y * bins_per_length);
    bin_of_[i] = static_cast<std::uint32_t>(row) * columns_ + static_cast<std::uint32_t>(column);
    ++start_[bin_of_[i] + 2];
  }
  for (std::size_t b = 2; b < start_.size(); ++b) start_[b] += start_[b - 1];
  items_.resize(count + 8);
  for (auto* column : {&x_, &y_, &reach_}) column->resize(count + 8);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Disc& disc = discs[i];
    const double reach = range * disc.radius + disc.margin;
    const std::uint32_t at = start_[bin_of_[i] + 1]++;
    items_[at] = i;
    x_[at] = static_cast<float>(disc.x - left_);
    y_[at] = static_cast<float>(disc.y - bottom_);
    reach_[at] = static_cast<float>(reach * (1 + 4 * rounding) + error);
  }
}

}  // namespace somas::model
