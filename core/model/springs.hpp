// What two cells of given kinds do to each other (docs/model.md, section 3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/model/world_state.hpp"

namespace somas::model {

/// Constants of the forces between two cells.
struct alignas(32) Spring {
  double stiffness = 0, adhesion = 0;
  double range = 1;    ///< activation distance / (r1 + r2), at least where they collide
  double contact = 0;  ///< 1 when ambrosia passes between cells within range

  friend bool operator==(const Spring&, const Spring&) = default;
};

/// The springs between all kinds of cells of a world, a kind being a state of an organism.
class SpringTable {
 public:
  explicit SpringTable(Strangers strangers = {}) : strangers_(strangers) {}

  /// Makes the table good for the cells that are now in the world.
  void prepare(const WorldState& world);

  [[nodiscard]] std::uint32_t kind(std::uint16_t organism, std::uint16_t state) const {
    return first_kind_[organism] + state;
  }
  [[nodiscard]] const Spring& between(std::uint32_t a, std::uint32_t b) const {
    return springs_[a * kinds_ + b];
  }
  /// The spring between any two cells when all are alike, else null.
  [[nodiscard]] const Spring* common() const { return uniform_ ? &common_ : nullptr; }
  /// The greatest range of all springs between the kinds present.
  [[nodiscard]] double range() const { return range_; }

 private:
  void list(const WorldState& world);

  Strangers strangers_;
  std::vector<const Tree*> trees_;  ///< for whom the springs were listed
  std::vector<std::uint32_t> first_kind_;
  std::uint32_t kinds_ = 0;
  std::vector<Spring> springs_;  ///< kinds x kinds
  Spring common_;
  bool uniform_ = false;
  double range_ = 1;
};

}  // namespace somas::model
