// Nutrients, ambrosia and energy (docs/model.md, section 2).
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/model/team.hpp"
#include "core/model/witness.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// A cell's controller outputs are read as shares: clamped to [0, 1], NaN as 0.
[[nodiscard]] inline double share(float output) {
  return output > 0 ? (output < 1 ? static_cast<double>(output) : 1.0) : 0.0;
}

/// Phase 5. Every stage reads what the one before left; sums run in canonical order.
class MetabolismSolver {
 public:
  /// Tells `witness` (may be null) from now on; it must outlive this.
  void tell(Witness* witness) { witness_ = witness; }
  /// Shares the work with `team` (null: nobody) from now on; it must outlive this.
  void use(Team* team) { team_ = team; }

  /// Uptake, conversion, diffusion, cost. Throws PluginFailure for a content that is negative or no
  /// number.
  void run(const Ecosystem& ecosystem, WorldState& world, const FloatMatrix& outputs);

 private:
  struct Step;
  void prepare(const Step& step);
  // The stages, for some of the cells of a range: they write to these cells only.
  void ask(const Step& step, const CellRange& cells);
  void take_up(const Step& step, const CellRange& cells);
  void convert(const Step& step, const CellRange& cells);
  void offer(const Step& step, const CellRange& cells);
  void accept(const Step& step, const CellRange& cells);
  void diffuse(const Step& step, const CellRange& cells);
  void pay(const Step& step, const CellRange& cells);
  // Between them, in canonical order.
  void sum_demands(const Step& step);
  void refuse_contents(const Step& step) const;
  void book_gifts_to_strangers(WorldState& world) const;
  void tell_of_gifts(const WorldState& world) const;
  void empty_squares(const Step& step);
  void keep_books(const Step& step) const;

  Team* team_ = nullptr;
  Witness* witness_ = nullptr;
  // By resource, then canonical place: what a cell asks for and then takes; the square of the
  // resource's grid under it, or the one behind the last: none.
  std::vector<double> demand_;
  std::vector<std::uint32_t> square_;
  std::vector<std::vector<double>> square_demand_;  ///< by resource, then square; 0 between steps
  std::atomic<bool> bad_content_ = false;
  // By cell.
  std::vector<double> room_;
  std::vector<double> offer_;            ///< to each of its contacts
  std::vector<double> gift_;             ///< what arrives of it
  std::vector<double> accepted_, gain_;  ///< share taken of what comes in, and how much that is
  std::vector<double> burnt_, spent_;    ///< for the books
  std::vector<double> lost_;             ///< the same, by canonical place
};

/// Energy at or below this is none.
inline constexpr double starving = 1e-9;

}  // namespace somas::model
