// Everything that the next step depends on, as one copyable value.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/model/cells.hpp"
#include "core/model/ecosystem.hpp"
#include "core/model/morphogens.hpp"

namespace somas::model {

/// Rows of moving things; storage behind the SDK's Table.
class TableStore final : public Table {
 public:
  explicit TableStore(std::size_t columns = 0) : columns_(columns) {}
  [[nodiscard]] std::uint32_t rows() const override { return rows_; }
  [[nodiscard]] std::span<double> column(Id c) override { return columns_.at(c); }
  [[nodiscard]] std::span<const double> column(Id c) const { return columns_.at(c); }
  [[nodiscard]] std::size_t columns() const { return columns_.size(); }
  void resize(std::uint32_t rows) override {
    for (auto& column : columns_) column.resize(rows);
    rows_ = rows;
  }

 private:
  std::uint32_t rows_ = 0;
  std::vector<std::vector<double>> columns_;
};

/// A running sum that keeps the rounding error of every addition (Neumaier), so that books over
/// millions of additions still balance to the last digits.
class Sum {
 public:
  Sum() = default;
  explicit Sum(double start, double error = 0) : sum_(start), error_(error) {}
  Sum& operator+=(double x) {
    const double next = sum_ + x;
    const bool sum_is_larger = (sum_ < 0 ? -sum_ : sum_) >= (x < 0 ? -x : x);
    error_ += sum_is_larger ? (sum_ - next) + x : (x - next) + sum_;
    sum_ = next;
    return *this;
  }
  [[nodiscard]] double value() const { return sum_ + error_; }
  /// The two parts of the value: what plain addition gives, and what it lost.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] double error() const { return error_; }

 private:
  double sum_ = 0, error_ = 0;
};

/// Where an organism's ambrosia and energy came from and went to, summed over its life. The books
/// (section 2): founder_ambrosia + taken + received = stored + burnt + given + lost(), and
/// founder_energy + burnt = energy stored + spent + energy_lost.
struct Ledger {
  double founder_ambrosia = 0, founder_energy = 0;
  Sum taken;            ///< from resources into ambrosia
  Sum burnt;            ///< ambrosia turned into energy
  Sum given;            ///< what arrived with other organisms
  Sum received;         ///< what arrived from other organisms
  Sum lost_efficiency;  ///< in diffusion and apoptosis, by the giver's efficiency
  Sum lost_overflow;    ///< above a capacity: at specialization, at apoptosis gifts
  Sum lost_death;       ///< with cells that died inside the world
  Sum lost_outside;     ///< with cells that left it
  Sum spent;            ///< energy paid for actions
  Sum energy_lost;      ///< with cells that died or left

  [[nodiscard]] double lost() const {
    return lost_efficiency.value() + lost_overflow.value() + lost_death.value() +
           lost_outside.value();
  }
};

struct OrganismState {
  std::uint64_t key = 0;
  std::uint32_t roster_index = 0;
  const Phenotype* phenotype = nullptr;
  std::uint64_t next_id = 0;
  std::uint32_t live = 0;
  MorphogenFields fields;
  Ledger ledger;
  Outcome outcome;
  double shares = 0;                  ///< of the world's live cells, summed over inhabited steps
  std::vector<std::uint64_t> deaths;  ///< by cause
};

/// The pairs that ambrosia can pass between, after the last mechanics: cells of one organism that
/// adhere to each other; with `strangers.feed` also those of two organisms that touch, by adhesion
/// or else by collision.
struct Contacts {
  struct Run {
    std::uint32_t begin = 0, end = 0;
  };
  std::vector<Run> runs;             ///< by cell: where among the items, in canonical order
  std::vector<std::uint32_t> items;  ///< cells; the runs of those near each other stand together

  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t cell) const {
    return {items.data() + runs[cell].begin, items.data() + runs[cell].end};
  }
  /// For so many cells, which touch nobody.
  void reset(std::size_t cells) {
    runs.assign(cells, {});
    items.clear();
  }
  /// Follows a reorganisation that removed cells: `new_index` by old index.
  void remap(std::span<const std::uint32_t> new_index);
};

struct WorldState {
  std::uint64_t seed = 0;
  std::uint64_t step = 0;             ///< the step that runs or comes next
  std::uint64_t inhabited_steps = 0;  ///< at whose end somebody lived
  bool finished = false;
  CellStore cells;
  Contacts contacts;
  std::vector<OrganismState> organisms;  ///< by ascending key
  std::vector<std::vector<double>> grids;
  std::vector<TableStore> tables;
  std::vector<double> scalars;
  std::vector<double> parameters;  ///< by variable parameter Id: what it is now

  [[nodiscard]] const State& state_of(std::uint32_t cell) const {
    return organisms[cells.organism[cell]].phenotype->tree->states[cells.state[cell]];
  }
};

}  // namespace somas::model
