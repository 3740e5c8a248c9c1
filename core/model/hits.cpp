#include "core/model/hits.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/model/compress.hpp"
#include "core/model/lanes.hpp"

namespace somas::model {

namespace {

constexpr std::uint32_t nobody = 0xFFFFFFFFu;
/// Squares of the marks along a bin's side; there is a margin of one bin all round.
constexpr std::uint32_t fineness = 3;
/// Half the length of a short path, in sides of a bin. With half a side, the farthest that a disc
/// reaches, it is 1.98 squares: no more than two squares from the disc's own are near it.
constexpr double short_half = 0.16;
/// In a longer grid the rounding of a disc's place might be more than what is left.
constexpr std::uint32_t longest_grid = 1 << 15;
/// Paths that are looked up in the marks together, and paths searched for together.
constexpr std::size_t most_looked_up = 512, most_searched = 32;
/// More than are in a near cache.
constexpr std::size_t many_bodies = 4000;
/// Rows of bins whose discs are asked for early: all of a short path.
constexpr std::uint32_t rows_fetched = 3;

using FourPlaces = std::int32_t __attribute__((vector_size(16)));

/// As whole numbers from 0 to `last`; what is no number as 0.
inline void to_items(const Four& values, const Four& last, FourPlaces& items) {
  const Four none{};
  const Four some = values > none ? values : none;
  const Four within = some < last ? some : last;
  items = __builtin_convertvector(within, FourPlaces);
}

/// The lanes that are in a set of four, from the first on; what follows them is not used.
constexpr auto lanes_in = [] {
  std::array<FourPlaces, 16> lists{};
  for (std::int32_t set = 0; set < 16; ++set) {
    std::int32_t list[4]{}, length = 0;
    for (std::int32_t lane = 0; lane < 4; ++lane)
      if ((set >> lane & 1) != 0) list[length++] = lane;
    lists[static_cast<std::size_t>(set)] = FourPlaces{list[0], list[1], list[2], list[3]};
  }
  return lists;
}();

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
  std::size_t count = 0;
  std::array<Segment, most_searched> paths;
  std::array<Window, most_searched> windows;
  std::array<std::uint32_t, most_searched> best;
  std::array<double, most_searched> best_distance;
  // Cells that paths may meet, and whose paths.
  static constexpr std::size_t most_candidates = 128;
  std::size_t candidate_count = 0;
  std::array<std::uint32_t, most_candidates> candidates, candidate_paths;
};

void HitFinder::prepare(std::span<const Body> bodies, const DiscBins& bins,
                        std::span<const std::uint32_t> cells, std::span<const std::uint32_t> rank) {
  bodies_ = bodies;
  cells_ = cells;
  rank_ = rank;
  bins_ = &bins;
  marked_ = false;
}

void HitFinder::expect(std::size_t paths, Team* team) {
  constexpr std::size_t many = 1024;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (marked_ || (paths < many && paths < bodies_.size())) return;
  const bool precise = bins_->columns() < longest_grid && bins_->rows() < longest_grid &&
                       bins_->side() < infinite && bins_->per_length() < infinite;
  if (precise) mark(team);
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
/// these rows, in the one below and in the one above.
void HitFinder::mark_round(std::uint32_t begin_row, std::uint32_t end_row) {
  const std::uint32_t begin = begin_row * fineness, end = end_row * fineness;
  const auto marks = marks_.begin();
  std::fill(marks + static_cast<std::ptrdiff_t>(std::size_t{begin} * stride_),
            marks + static_cast<std::ptrdiff_t>(std::size_t{end} * stride_), 0);
  const std::size_t first = begin_row < 2 ? 0 : begin_row - 2;
  const std::size_t last = std::min(end_row, bins_->rows());
  const std::uint32_t discs_end = bins_->start(last * bins_->columns());
  const double per_square = per_square_;
  const double width = columns_ - 2 * fineness, height = rows_ - 2 * fineness;
  for (std::uint32_t k = bins_->start(first * bins_->columns()); k < discs_end; ++k) {
    const double x = bins_->x()[k] * per_square, y = bins_->y()[k] * per_square;
    // Discs that are nowhere are near nothing. The last may be rounded past the border.
    if (!((x >= 0) & (x < width + 1) & (y >= 0) & (y < height + 1))) continue;
    const std::uint32_t left = static_cast<std::uint32_t>(x) + fineness - 2;
    const std::uint32_t bottom = static_cast<std::uint32_t>(y) + fineness - 2;
    // Two squares on either side of its own; seldom in two words.
    constexpr std::uint64_t five = 0b11111;
    const std::uint32_t shift = left % 64;
    std::uint64_t* word = &marks_[0] + left / 64;
    const auto mark = [&](std::size_t row, std::uint64_t bits) { word[row * stride_] |= bits; };
    const std::uint32_t low = std::max(bottom, begin), high = std::min(bottom + 5, end);
    for (std::uint32_t row = low; row < high; ++row) mark(row, five << shift);
    if (shift <= 59) continue;
    ++word;
    for (std::uint32_t row = low; row < high; ++row) mark(row, five >> (64 - shift));
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
  const Four last{columns_ - 1.0, rows_ - 1.0, columns_ - 1.0, rows_ - 1.0};
  const Four corner{bins_->left(), bins_->bottom(), bins_->left(), bins_->bottom()};
  const double per_square = per_square_, most_square = short_ * short_;
  const std::uint64_t* marks = marks_.data();
  const std::uint32_t stride = stride_;
  // Of two paths at a time: their square lengths, one after another twice, and the squares that
  // their middles lie in.
  const auto place = [&](const Segment* two, Four& squares, FourPlaces& middles) {
    Four one, other;
    std::memcpy(&one, two, sizeof one);
    std::memcpy(&other, two + 1, sizeof other);
    const Four start = __builtin_shufflevector(one, other, 0, 1, 4, 5);
    const Four end = __builtin_shufflevector(one, other, 2, 3, 6, 7);
    const Four way = end - start;
    squares = way * way;
    to_items((0.5 * start + 0.5 * end - corner) * per_square + fineness, last, middles);
  };
  const auto list = [&](const Segment* four, std::uint32_t first, std::uint32_t within) {
    Four low, high;
    FourPlaces low_middles, high_middles;
    place(four, low, low_middles);
    place(four + 2, high, high_middles);
    const Four x = __builtin_shufflevector(low, high, 0, 2, 4, 6);
    const Four y = __builtin_shufflevector(low, high, 1, 3, 5, 7);
    const FourMask is_short = x + y <= most_square;
    std::uint32_t some = ~bits_of(is_short);
    const auto mark = [&](std::int32_t column, std::int32_t row) -> std::uint32_t {
      const auto c = static_cast<std::uint32_t>(column), r = static_cast<std::uint32_t>(row);
      return marks[r * stride + c / 64] >> (c % 64) & 1;
    };
    some |= mark(low_middles[0], low_middles[1]) | mark(low_middles[2], low_middles[3]) << 1;
    some |= mark(high_middles[0], high_middles[1]) << 2;
    some |= mark(high_middles[2], high_middles[3]) << 3;
    some &= within;
    const FourPlaces which = lanes_in[some] + static_cast<std::int32_t>(first);
    std::memcpy(near + listed, &which, sizeof which);
    listed += static_cast<std::size_t>(std::popcount(some));
  };
  std::uint32_t i = 0;
  for (; i + 4 <= segments.size(); i += 4) list(&segments[i], i, 0b1111);
  // The last ones are joined by others that do not count.
  if (const std::size_t left = segments.size() - i; left > 0) {
    std::array<Segment, 4> four{};
    std::copy_n(segments.begin() + i, left, four.begin());
    list(four.data(), i, (1u << left) - 1);
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
        if (search.best[p] != nobody)
          hits[begin + near[n + p]] = static_cast<std::int32_t>(cells_[search.best[p]]);
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
    FourPlaces bin;
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
      if (search.candidate_count > Search::most_candidates - 8) meet_candidates(search);
      // All eight are written; the next ones take the places of those that are too far off.
      const std::uint32_t set = bits_of(near);
      EightItems places;
      std::memcpy(&places, bins_->items() + k, sizeof places);
      compress(set, places);
      const EightItems paths = path + EightItems{};
      std::memcpy(&search.candidates[search.candidate_count], &places, sizeof places);
      std::memcpy(&search.candidate_paths[search.candidate_count], &paths, sizeof paths);
      search.candidate_count += static_cast<std::size_t>(std::popcount(set));
    }
  }
}

void HitFinder::meet_candidates(Search& search) const {
  const std::size_t count = search.candidate_count;
  if (bodies_.size() > many_bodies)
    for (std::size_t c = 0; c < count; ++c) __builtin_prefetch(&bodies_[search.candidates[c]]);
  for (std::size_t c = 0; c < count; ++c) {
    const std::uint32_t path = search.candidate_paths[c], place = search.candidates[c];
    const Body& body = bodies_[place];
    const double t = meeting(search.paths[path], body.x, body.y, body.radius);
    std::uint32_t& best = search.best[path];
    double& distance = search.best_distance[path];
    if (t < 0 || t > distance || (t == distance && is_later(place, best))) continue;
    best = place;
    distance = t;
  }
  search.candidate_count = 0;
}

}  // namespace somas::model
