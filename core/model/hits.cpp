#include "core/model/hits.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

constexpr std::uint32_t nobody = 0xFFFFFFFFu;  // -1
/// Squares of the marks along a bin's side; the margin round the grid is one bin.
constexpr std::uint32_t fineness = 4;
/// Half the length of a short path, in sides of a bin.
constexpr double short_half = 0.125;
/// Paths that are looked up in the marks together, and paths searched for together.
constexpr std::size_t most_looked_up = 512, most_searched = 32;
/// Rows of bins whose discs are asked for early: all of a short path.
constexpr std::uint32_t rows_fetched = 3;

using FourItems = std::int32_t __attribute__((vector_size(16)));

/// As whole numbers from 0 to `last`; what is no number as 0.
inline void to_items(Four values, const Four& last, FourItems& items) {
  values = values > 0 ? values : Four{};
  values = values < last ? values : last;
  items = __builtin_convertvector(values, FourItems);
}

}  // namespace

double meeting(const Segment& s, double x, double y, double radius) {
  const double fx = s.x0 - x, fy = s.y0 - y;
  const double outside = fx * fx + fy * fy - radius * radius;
  if (outside <= 0) return 0;
  const double dx = s.x1 - s.x0, dy = s.y1 - s.y0;
  const double towards = fx * dx + fy * dy;
  if (towards >= 0) return -1;
  const double square = dx * dx + dy * dy;
  const double discriminant = towards * towards - square * outside;
  if (discriminant < 0) return -1;
  const double t = (-towards - std::sqrt(discriminant)) / square;
  return t <= 1 ? t : -1;
}

/// Paths that are searched for together.
struct HitFinder::Search {
  /// The bins with all discs that a path may meet, and a circle round the path.
  struct Window {
    std::size_t bin;  ///< the first; `high` rows of `wide` bins
    std::uint32_t wide, high;
    float x, y, radius;
    std::array<std::uint32_t, rows_fetched> discs;  ///< where the discs of the first rows begin
  };
  /// A cell that a path may meet.
  struct Candidate {
    std::uint32_t path, place;
  };

  std::size_t count = 0;
  std::array<Segment, most_searched> paths;
  std::array<Window, most_searched> windows;
  std::array<std::uint32_t, most_searched> best;
  std::array<double, most_searched> best_distance;
  std::size_t candidate_count = 0;
  std::array<Candidate, 128> candidates;
};

void HitFinder::prepare(std::span<const Body> bodies, const DiscBins& bins) {
  bodies_ = bodies;
  bins_ = &bins;
  marked_ = false;
}

void HitFinder::expect(std::size_t paths, Team* team) {
  constexpr std::size_t many = 1024;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const bool pays = paths >= many || paths >= bodies_.size();
  if (!marked_ && pays && bins_->side() < infinite && bins_->per_length() < infinite) mark(team);
}

void HitFinder::mark(Team* team) {
  columns_ = fineness * (bins_->columns() + 2);
  rows_ = fineness * (bins_->rows() + 2);
  stride_ = columns_ / 64 + 1;
  per_square_ = fineness * bins_->per_length();
  short_ = 2 * short_half * bins_->side();
  marks_.resize(std::size_t{stride_} * rows_);
  share(team, bins_->rows() + 2, bodies_.size(),
        [this](std::uint32_t begin, std::uint32_t end) { mark_round(begin, end); });
  marked_ = true;
}

/// Marks squares in rows of bins, the lower margin being the first, that are near the discs in
/// these rows, in the one below and in the one above: no disc reaches farther.
void HitFinder::mark_round(std::uint32_t begin_row, std::uint32_t end_row) {
  const std::uint32_t begin = begin_row * fineness, end = end_row * fineness;
  std::fill(&marks_[std::size_t{begin} * stride_], &marks_[0] + std::size_t{end} * stride_, 0);
  // The outermost squares stay free: all that is beyond is looked up there.
  const auto low = static_cast<std::int32_t>(std::max(begin, 1u));
  const auto high = static_cast<std::int32_t>(std::min(end, rows_ - 1) - 1);
  const auto right_most = static_cast<std::int32_t>(columns_ - 2);
  const std::size_t first = begin_row < 2 ? 0 : begin_row - 2;
  const std::size_t last = std::min(end_row, bins_->rows());
  const std::uint32_t discs_end = bins_->start(last * bins_->columns());
  for (std::uint32_t k = bins_->start(first * bins_->columns()); k < discs_end; ++k) {
    const double reach =
        (bins_->reach()[k] + short_half * bins_->side()) * (1 + 1e-9) * per_square_;
    const double x = bins_->x()[k] * per_square_ + fineness;
    const double y = bins_->y()[k] * per_square_ + fineness;
    // Discs that are nowhere are near nothing.
    if (!((x <= columns_) & (y <= rows_) & (reach <= columns_ + rows_))) continue;
    const std::int32_t left = std::max(static_cast<std::int32_t>(x - reach), 1);
    const std::int32_t right = std::min(static_cast<std::int32_t>(x + reach), right_most);
    const std::int32_t bottom = std::max(static_cast<std::int32_t>(y - reach), low);
    const std::int32_t top = std::min(static_cast<std::int32_t>(y + reach), high);
    for (std::int32_t word = left / 64; word <= right / 64; ++word) {
      std::uint64_t bits = ~std::uint64_t{0};
      if (word == left / 64) bits &= ~std::uint64_t{0} << (left % 64);
      if (word == right / 64) bits &= ~std::uint64_t{0} >> (63 - right % 64);
      for (std::int32_t row = bottom; row <= top; ++row)
        marks_[static_cast<std::size_t>(row) * stride_ + static_cast<std::size_t>(word)] |= bits;
    }
  }
}

/// Lists the segments that may meet a cell, at most `most_looked_up`, without a branch for each:
/// nobody could foretell it.
std::size_t HitFinder::list_near(std::span<const Segment> segments, std::uint32_t* near) const {
  std::size_t listed = 0;
  if (!marked_) {
    for (; listed < segments.size(); ++listed) near[listed] = static_cast<std::uint32_t>(listed);
    return listed;
  }
  const Four last_column = Four{} + (columns_ - 1.0), last_row = Four{} + (rows_ - 1.0);
  for (std::size_t i = 0; i < segments.size(); i += 4) {
    const std::size_t last = segments.size() - 1;
    Four s[4];
    read_columns(segments[i], segments[std::min(i + 1, last)], segments[std::min(i + 2, last)],
                 segments[std::min(i + 3, last)], s);
    const Four dx = s[2] - s[0], dy = s[3] - s[1];
    const FourMask may_be_long = ~(dx * dx + dy * dy <= short_ * short_);
    const Four x = (0.5 * s[0] + 0.5 * s[2] - bins_->left()) * per_square_ + fineness;
    const Four y = (0.5 * s[1] + 0.5 * s[3] - bins_->bottom()) * per_square_ + fineness;
    FourItems column, row;
    to_items(x, last_column, column);
    to_items(y, last_row, row);
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const auto c = static_cast<std::size_t>(column[lane]);
      const std::uint64_t word = marks_[static_cast<std::size_t>(row[lane]) * stride_ + c / 64];
      near[listed] = static_cast<std::uint32_t>(i + lane);
      listed += ((word >> (c % 64)) | static_cast<std::uint64_t>(may_be_long[lane])) & 1 &
                static_cast<std::uint64_t>(i + lane <= last);
    }
  }
  return listed;
}

void HitFinder::first(std::span<const Segment> segments, std::span<std::int32_t> hits) const {
  std::array<std::uint32_t, most_looked_up + 4> near;
  Search search;
  for (std::size_t begin = 0; begin < segments.size(); begin += most_looked_up) {
    const std::size_t looked_up = std::min(most_looked_up, segments.size() - begin);
    const std::size_t listed = list_near(segments.subspan(begin, looked_up), near.data());
    std::fill_n(hits.begin() + static_cast<std::ptrdiff_t>(begin), looked_up, -1);
    for (std::size_t n = 0; n < listed; n += most_searched) {
      search.count = std::min(most_searched, listed - n);
      for (std::size_t p = 0; p < search.count; ++p)
        search.paths[p] = segments[begin + near[n + p]];
      find(search);
      for (std::size_t p = 0; p < search.count; ++p)
        hits[begin + near[n + p]] = static_cast<std::int32_t>(search.best[p]);
    }
  }
}

std::int32_t HitFinder::first(const Segment& segment) const {
  std::int32_t hit = -1;
  first(std::span(&segment, 1), std::span(&hit, 1));
  return hit;
}

/// What a step is going to read has been asked for by the one before.
void HitFinder::find(Search& search) const {
  find_windows(search);
  fetch_discs(search);
  for (std::size_t p = 0; p < search.count; ++p) {
    search.best[p] = nobody;
    search.best_distance[p] = 2;
  }
  search.candidate_count = 0;
  for (std::uint32_t p = 0; p < search.count; ++p) list_candidates(search, p);
  meet_candidates(search);
}

void HitFinder::find_windows(Search& search) const {
  const Four corner{bins_->left(), bins_->bottom(), bins_->left(), bins_->bottom()};
  const double last_column = bins_->columns() - 1.0, last_row = bins_->rows() - 1.0;
  const Four last{last_column, last_row, last_column, last_row};
  const Four wider = Four{} + bins_->widest();
  for (std::size_t p = 0; p < search.count; ++p) {
    Four path;
    std::memcpy(&path, &search.paths[p], sizeof path);
    path -= corner;
    const Four back = __builtin_shufflevector(path, path, 2, 3, 0, 1);
    const Four low = path < back ? path : back, high = path < back ? back : path;
    const Four size = high - low;
    const double length = size[0] + size[1];  // at least the path's
    // Only discs whose centre lies within the widest reach of the path's bounds can be met.
    const Four bounds = __builtin_shufflevector(low - wider, high + wider, 0, 1, 6, 7);
    FourItems bin;
    to_items(bounds * bins_->per_length(), last, bin);
    Search::Window& window = search.windows[p];
    window.bin =
        static_cast<std::size_t>(bin[1]) * bins_->columns() + static_cast<std::size_t>(bin[0]);
    window.wide = static_cast<std::uint32_t>(bin[2] - bin[0] + 1);
    window.high = length >= 0 ? static_cast<std::uint32_t>(bin[3] - bin[1] + 1) : 0;
    const Four middle = 0.5 * path + 0.5 * back;
    window.x = static_cast<float>(middle[0]);
    window.y = static_cast<float>(middle[1]);
    window.radius = static_cast<float>(0.5 * length * (1 + 4 * DiscBins::rounding));
    for (std::uint32_t row = 0; row < std::min(window.high, rows_fetched); ++row)
      window.discs[row] = bins_->start(window.bin + std::size_t{row} * bins_->columns());
  }
}

void HitFinder::fetch_discs(const Search& search) const {
  for (std::size_t p = 0; p < search.count; ++p) {
    const Search::Window& window = search.windows[p];
    for (std::uint32_t row = 0; row < std::min(window.high, rows_fetched); ++row) {
      const std::uint32_t k = window.discs[row];
      __builtin_prefetch(bins_->x() + k);
      __builtin_prefetch(bins_->y() + k);
      __builtin_prefetch(bins_->reach() + k);
      __builtin_prefetch(bins_->items() + k);
    }
  }
}

/// Most discs in the window are too far off to be met at all.
void HitFinder::list_candidates(Search& search, std::uint32_t path) const {
  constexpr EightMask lanes{0, 1, 2, 3, 4, 5, 6, 7};
  const Search::Window& window = search.windows[path];
  std::size_t bin = window.bin;
  for (std::uint32_t row = 0; row < window.high; ++row, bin += bins_->columns()) {
    const std::uint32_t end = bins_->start(bin + window.wide);
    for (std::uint32_t k = bins_->start(bin); k < end; k += 8) {
      EightFloats xs, ys, reach;
      std::memcpy(&xs, bins_->x() + k, sizeof xs);
      std::memcpy(&ys, bins_->y() + k, sizeof ys);
      std::memcpy(&reach, bins_->reach() + k, sizeof reach);
      const EightFloats dx = xs - window.x, dy = ys - window.y;
      reach += window.radius;
      const EightMask near =
          (dx * dx + dy * dy <= reach * reach) & (lanes < static_cast<std::int32_t>(end - k));
      if (search.candidate_count > search.candidates.size() - 8) meet_candidates(search);
      for (std::uint32_t set = bits_of(near); set != 0; set &= set - 1) {
        const std::uint32_t place =
            bins_->items()[k + static_cast<std::uint32_t>(std::countr_zero(set))];
        __builtin_prefetch(&bodies_[place]);
        search.candidates[search.candidate_count++] = {path, place};
      }
    }
  }
}

void HitFinder::meet_candidates(Search& search) const {
  for (const auto [path, place] : std::span(search.candidates).first(search.candidate_count)) {
    const Body& body = bodies_[place];
    const double t = meeting(search.paths[path], body.x, body.y, body.radius);
    std::uint32_t& best = search.best[path];
    double& distance = search.best_distance[path];
    if (t < 0 || t > distance || (t == distance && place > best)) continue;
    best = place;
    distance = t;
  }
  search.candidate_count = 0;
}

}  // namespace somas::model
