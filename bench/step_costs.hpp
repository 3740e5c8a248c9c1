// What a step has to do at least: operations and bytes of each phase, from how many items of each
// kind there are.
#pragma once

#include <string>
#include <vector>

namespace somas::bench {

/// Of each cell in each step, on average, unless said otherwise. Counted in a life.
struct Items {
  double patches = 0;  ///< of the nutrients' grid
  double squares = 0;  ///< of morphogens, all kinds, that are swept
  double kinds = 0;    ///< of morphogens
  double inputs = 0;   ///< of the network
  double outputs = 0;
  double targets = 0;         ///< proteins whose concentration changes: outputs and regulators
  double deciding = 0;        ///< cells without an action
  double dividing = 0;        ///< cells that grow
  double builds = 0;          ///< times that pairs are found, in a step
  double candidates = 0;      ///< pairs looked at each time
  double pairs = 0;           ///< pairs found each time, a margin included
  double touching = 0;        ///< pairs in contact
  double substeps = 0;        ///< in a step
  double particles = 0;       ///< in flight
  double column_bytes = 0;    ///< of a cell in the storage, the network's memory included
  double births_storage = 0;  ///< times that the storage is put in order after births, in a step
  double deaths_storage = 0;  ///< the same after deaths
};

/// Operations by the value, and bytes that move when every array is read or written once in a pass.
struct Work {
  double flops64 = 0, flops32 = 0;  ///< additions, multiplications, comparisons that select
  double divisions64 = 0, divisions32 = 0, roots64 = 0, roots32 = 0;
  double bytes = 0;

  Work& operator+=(const Work& other);
};
[[nodiscard]] Work operator*(double times, Work work);
[[nodiscard]] Work operator+(Work a, const Work& b);

/// The rows of the roofline, in the order of a step.
enum class Part {
  nutrients,
  sweep,
  sense_deposit,
  control,
  cycle,
  metabolism,
  find_pairs,
  substeps,
  contacts,
  particles,
  deaths
};
inline constexpr std::size_t parts = 11;
[[nodiscard]] const char* name_of(Part part);

/// Of a cell in a step.
[[nodiscard]] Work work_of(Part part, const Items& items);

}  // namespace somas::bench
