// Islands of bodies that cannot touch each other, and an order of bodies island by island.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/model/lanes.hpp"
#include "core/model/parted_counts.hpp"
#include "core/model/team.hpp"

namespace somas::model {

/// Where bodies are: the k-th at (x[i], y[i]), i being index[k], or k without one.
struct Sites {
  std::span<const double> x, y;
  std::span<const std::uint32_t> index;

  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(x.size()); }
  [[nodiscard]] Two operator[](std::size_t k) const {
    const std::size_t i = index.empty() ? k : index[k];
    return Two{x[i], y[i]};
  }
};

/// Bodies nearer to each other than some distance are of one island, and so are those whom a chain
/// of such bodies joins. Numbered island by island, within each as before, neighbours stand close
/// together in memory, however far apart they were, and of two of them the lower one stays so.
class Islands {
 public:
  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) { team_ = team; }
  /// Gives each body its number. Returns false, and no numbers, where all are of one island.
  bool number(const Sites& sites, double distance, std::vector<std::uint32_t>& numbers);
  /// Where there are several: the lowest number of each and, last, how many bodies there are.
  [[nodiscard]] std::span<const std::uint32_t> starts() const { return start_; }

 private:
  /// Bins of a row with bodies, side by side.
  struct Run {
    std::uint32_t row, begin, end;
    std::uint32_t joined;  ///< with this run, itself or a lower one
  };
  struct Bounds {
    Two low, high;
  };
  [[nodiscard]] static Bounds bounds_of(const Sites& sites, Stretch own);
  void lay_out(const Sites& sites, double distance, unsigned parts);
  void mark(const Sites& sites, unsigned parts);
  void list_runs();
  void join_rows();
  [[nodiscard]] std::uint32_t root(std::uint32_t run);
  void join(std::uint32_t one, std::uint32_t other);
  [[nodiscard]] std::uint32_t name_islands();
  void count_up(std::uint32_t islands, std::vector<std::uint32_t>& numbers, unsigned parts);

  std::vector<Bounds> bounds_;  ///< by part
  Two low_{};
  double per_length_ = 1;
  std::uint32_t columns_ = 1, rows_ = 1, stride_ = 2;  ///< a row ends with one bin more, empty
  std::vector<std::uint8_t> inhabited_;                ///< by bin
  std::vector<std::uint32_t> bin_of_;                  ///< by body
  std::vector<std::uint32_t> island_;                  ///< of inhabited bins
  std::vector<std::uint32_t> name_;                    ///< of the island, by run
  std::vector<std::uint32_t> start_;                   ///< by island
  std::vector<Run> runs_;
  Team* team_ = nullptr;
  PartedCounts counts_;
};

}  // namespace somas::model
