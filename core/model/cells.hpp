// Storage of the cells of all organisms, structure of arrays.
//
// Cells are kept sorted by (organism, state, id), so that a controller batch is a contiguous range.
// Whatever sums over cells uses `order` instead, the canonical (organism, id), so that the storage
// order never reaches the arithmetic. Organisms are numbered by ascending key.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "somas/sdk/types.hpp"

#include "core/model/schema.hpp"
#include "core/model/team.hpp"

namespace somas::model {

enum class Action : std::uint8_t { none, quiescence, division, specialization, apoptosis };

/// Owning channel-major floats; lanes padded so that growth seldom moves memory.
class FloatMatrix {
 public:
  void reshape(std::uint32_t channels, std::uint32_t lanes);  ///< keeps what fits, new values are 0
  [[nodiscard]] std::uint32_t channels() const { return channels_; }
  [[nodiscard]] float* row(std::uint32_t c) { return data_.data() + c * stride_; }
  [[nodiscard]] const float* row(std::uint32_t c) const { return data_.data() + c * stride_; }
  [[nodiscard]] Matrix<float> lanes(std::uint32_t first, std::uint32_t count,
                                    std::uint32_t channels) {
    return {data_.data() + first, channels, count, stride_};
  }
  [[nodiscard]] Matrix<const float> lanes(std::uint32_t first, std::uint32_t count,
                                          std::uint32_t channels) const {
    return {data_.data() + first, channels, count, stride_};
  }

 private:
  std::uint32_t channels_ = 0;
  std::size_t stride_ = 0;
  std::vector<float> data_;
};

/// A contiguous range of cells with the same organism and state.
struct CellRange {
  std::uint16_t organism = 0, state = 0;
  std::uint32_t begin = 0, end = 0;

  [[nodiscard]] std::uint32_t count() const { return end - begin; }
};

/// All columns are `size()` long. Quantities are dimensionless (docs/model.md).
struct CellStore {
  std::vector<double> x, y, vx, vy, radius;
  std::vector<double> energy, ambrosia;
  std::vector<double> pressure, stress_xx, stress_xy, stress_yy;  ///< after the last mechanics
  std::vector<std::uint64_t> id, parent, born;                    ///< born: step of birth
  std::vector<std::uint32_t> remaining;                           ///< steps until the action ends
  std::vector<std::uint32_t> cause;                               ///< of death; no_cause: alive
  std::vector<std::uint16_t> organism, state, target;             ///< target of a specialization
  std::vector<Action> action;
  std::vector<std::uint8_t> dead;
  std::vector<std::vector<double>> values;  ///< by cell value Id
  std::vector<std::vector<double>> damage;  ///< by hazard Id
  FloatMatrix memory;                       ///< of the controller

  /// Derived, kept by `reorganise`.
  std::vector<CellRange> ranges;
  std::vector<std::uint32_t> order;  ///< storage indices in canonical order
  std::vector<std::uint32_t> rank;   ///< place in `order` of each cell

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(x.size()); }

  /// Calls visit(vector&) for every column but the memory.
  template <class Visit>
  void each_column(Visit&& visit) {
    visit_columns(*this, visit);
  }
  template <class Visit>
  void each_column(Visit&& visit) const {
    visit_columns(*this, visit);
  }

  /// Appends a cell, all columns zero but cause (none); not yet in ranges and order. Returns its
  /// index. `memory_rows` is at least what any controller of the world needs.
  std::uint32_t append(std::uint32_t memory_rows);
  /// Copies every column of cell `from` into cell `to`.
  void copy_cell(std::uint32_t from, std::uint32_t to);

  void kill(std::uint32_t cell, Id why) {
    if (dead[cell] != 0) return;  // the first cause counts
    dead[cell] = 1;
    cause[cell] = why;
  }

 private:
  template <class Self, class Visit>
  static void visit_columns(Self& s, Visit&& visit) {
    visit(s.x), visit(s.y), visit(s.vx), visit(s.vy), visit(s.radius);
    visit(s.energy), visit(s.ambrosia);
    visit(s.pressure), visit(s.stress_xx), visit(s.stress_xy), visit(s.stress_yy);
    visit(s.id), visit(s.parent), visit(s.born), visit(s.remaining), visit(s.cause);
    visit(s.organism), visit(s.state), visit(s.target), visit(s.action), visit(s.dead);
    for (auto& column : s.values) visit(column);
    for (auto& column : s.damage) visit(column);
  }
};

inline constexpr std::uint32_t gone = 0xFFFFFFFFu;

/// Removes cells marked in `remove` (may be empty: none), restores the sort order after births,
/// deaths and changes of state, and renews ranges and order. Allocation-free once warm.
class Reorganiser {
 public:
  void run(CellStore& cells, std::span<const std::uint8_t> remove);
  /// Shares the moving of columns with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) { team_ = team; }
  /// New place of each old index, or `gone`; valid until the next run.
  [[nodiscard]] std::span<const std::uint32_t> new_index() const { return new_index_; }

 private:
  void list_changes(const CellStore& cells, std::span<const std::uint8_t> remove);
  [[nodiscard]] std::uint32_t place_of(const CellStore& cells, std::uint32_t cell) const;
  void list_runs(const CellStore& cells);
  void list_new_index(std::uint32_t old_count);
  void follow_order(CellStore& cells);
  void list_lost_ranks(const CellStore& cells);
  template <class T>
  void gather(T* column, std::vector<std::byte>& scratch) const;
  void gather_columns(CellStore& cells);

  std::vector<std::uint32_t> leavers_, moved_, lost_ranks_;
  std::uint32_t count_ = 0;  ///< of cells, when all is done
  std::vector<std::uint32_t> new_index_, next_order_;
  /// Cells that stay side by side: `count` of them go from old to new places.
  struct Run {
    std::uint32_t to, from, count;
  };
  std::vector<Run> runs_;        ///< of all from the first cell on that does not stay in place
  std::vector<Run> order_runs_;  ///< of places in canonical order
  bool only_removals_ = false, only_births_ = false;
  std::uint32_t first_newborn_ = 0;  ///< they stood from there on
  /// A column, by its place among all, and what moves it.
  struct Move {
    void* column;
    void (*gather)(const Reorganiser& how, void* column, std::vector<std::byte>& scratch);
  };
  std::vector<Move> moves_;
  std::vector<std::vector<std::byte>> scratch_{1};  ///< by part
  Team* team_ = nullptr;
};

}  // namespace somas::model
