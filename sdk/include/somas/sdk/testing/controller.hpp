/// @file
/// The conformance check of controllers.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "somas/sdk/controller.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/testing/heritable.hpp"
#include "somas/sdk/testing/ports.hpp"

namespace somas::testing {

/// How check_controller looks at a controller.
struct ControllerOptions {
  std::vector<Layout> layouts{};  ///< none: those of usual_ports()
  HeritableOptions heritable{};   ///< how its genes are looked at
  std::uint32_t lanes = 37;       ///< cells of one state; not a multiple of a vector's width
  std::uint32_t steps = 6;        ///< that each program is run
  std::uint64_t programs = 6;     ///< genomes that are expressed, for each layout
};

/// A new instance of the class that is checked, with its parameters.
using MakeController = std::function<std::unique_ptr<Controller>()>;

namespace detail {

/// One block of rows, with guards before, between and behind them.
class GuardedRows {
 public:
  GuardedRows(std::uint32_t rows, std::uint32_t lanes, float guard, float content)
      : rows_(rows), lanes_(lanes), stride_(lanes + margin), guard_(guard) {
    values_.assign((rows_ + 2) * stride_, guard);
    for (std::uint32_t r = 0; r < rows; ++r)
      for (std::uint32_t i = 0; i < lanes; ++i) at(r, i) = content;
  }

  [[nodiscard]] float& at(std::uint32_t row, std::uint32_t lane) {
    return values_[(row + 1) * stride_ + lane];
  }
  /// The lanes [first, first + count).
  [[nodiscard]] Matrix<float> lanes(std::uint32_t first, std::uint32_t count) {
    return {values_.data() + stride_ + first, rows_, count, stride_};
  }
  [[nodiscard]] bool guards_stand() const {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::size_t row = i / stride_, lane = i % stride_;
      const bool inside = row > 0 && row <= rows_ && lane < lanes_;
      if (!inside &&
          std::bit_cast<std::uint32_t>(values_[i]) != std::bit_cast<std::uint32_t>(guard_))
        return false;
    }
    return true;
  }

 private:
  static constexpr std::uint32_t margin = 11;
  std::uint32_t rows_, lanes_;
  std::size_t stride_;
  float guard_;
  std::vector<float> values_;
};

/// One way of running the same cells: which lane each is in, how lanes are grouped into batches,
/// and what stands where a program has no business.
struct Arrangement {
  std::vector<std::uint32_t> lane_of;  ///< of each cell
  std::vector<std::uint32_t> batches;  ///< sizes, adding up to the cells
  bool last_first = false;             ///< batches in reverse
  bool threads = false;                ///< each batch on a thread of its own
  float guard = -7.25f;
  std::uint32_t poison = 0x7FC5A5A5u;  ///< bits in the outputs before each step
};

/// The single checks of a controller on one layout; each throws what it finds.
class ProgramCheck {
 public:
  ProgramCheck(const MakeController& make, const Layout& layout, const ControllerOptions& options)
      : make_(make), layout_(layout), options_(options) {}

  void run(Failures& failures, const std::string& of) const;

 private:
  using PerCell = std::vector<std::vector<std::uint32_t>>;  ///< bits of all that a cell became

  [[nodiscard]] Genes genes(const Controller& controller, std::uint64_t number) const;
  [[nodiscard]] float input(std::uint32_t step, std::uint32_t channel, std::uint32_t cell) const;
  [[nodiscard]] PerCell life(const Program& program, std::uint16_t state,
                             const Arrangement& arrangement) const;
  void check_outputs(GuardedRows& out, const Arrangement& arrangement) const;
  [[nodiscard]] Arrangement straight() const;
  void arrangements(Failures& failures, const std::string& of, const Program& program,
                    std::uint16_t state, const PerCell& expected) const;
  void expressed_again(std::uint64_t number, std::uint16_t state, const PerCell& expected) const;

  const MakeController& make_;
  Layout layout_;
  ControllerOptions options_;
};

inline Genes ProgramCheck::genes(const Controller& controller, std::uint64_t number) const {
  Rng rng(options_.heritable.seed, 0, 0, stable_key("program"), number);
  Genes genes;
  controller.heritable().random(layout_, rng, genes);
  for (std::uint64_t i = 0; i < 5 * number; ++i) controller.heritable().mutate(layout_, rng, genes);
  return genes;
}

/// Mostly within [0, 1]; some cells sense more extreme things.
inline float ProgramCheck::input(std::uint32_t step, std::uint32_t channel,
                                 std::uint32_t cell) const {
  Rng rng(options_.heritable.seed, channel, step, stable_key("input"), cell);
  const double value = rng.uniform();
  if (cell % 9 == 7) return value < 0.5 ? 0.0f : 1.0f;
  if (cell % 9 == 8) return static_cast<float>(200 * value - 100);
  return static_cast<float>(value);
}

inline Arrangement ProgramCheck::straight() const {
  Arrangement a;
  a.lane_of.resize(options_.lanes);
  std::iota(a.lane_of.begin(), a.lane_of.end(), 0u);
  a.batches = {options_.lanes};
  return a;
}

/// What a program did to all cells in all steps. Throws on what no arrangement allows.
inline ProgramCheck::PerCell ProgramCheck::life(const Program& program, std::uint16_t state,
                                                const Arrangement& arrangement) const {
  const std::uint32_t cells = options_.lanes, memory_rows = program.memory_per_cell();
  const auto output_rows = static_cast<std::uint32_t>(layout_.outputs.size());
  GuardedRows in(layout_.input_channels, cells, arrangement.guard, 0);
  GuardedRows memory(memory_rows, cells, arrangement.guard, 0);
  GuardedRows out(output_rows, cells, arrangement.guard, 0);

  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
  for (std::uint32_t first = 0; const std::uint32_t count : arrangement.batches) {
    ranges.emplace_back(first, count);
    first += count;
  }
  if (arrangement.last_first) std::reverse(ranges.begin(), ranges.end());
  const auto call = [&](auto&& body) {
    const auto one = [&](std::size_t i) {
      const auto [first, count] = ranges[i];
      const Matrix<float> rows = in.lanes(first, count);
      Batch batch;
      batch.count = count;
      batch.state = state;
      batch.in = {rows.data, rows.channels, rows.lanes, rows.stride};
      batch.memory = memory.lanes(first, count);
      batch.out = out.lanes(first, count);
      body(batch);
    };
    if (arrangement.threads) return on_threads(ranges.size(), one);
    for (std::size_t i = 0; i < ranges.size(); ++i) one(i);
  };

  PerCell became(cells);
  for (std::uint32_t step = 0; step < options_.steps; ++step) {
    for (std::uint32_t cell = 0; cell < cells; ++cell) {
      const std::uint32_t lane = arrangement.lane_of[cell];
      for (std::uint32_t c = 0; c < layout_.input_channels; ++c)
        in.at(c, lane) = input(step, c, cell);
      for (std::uint32_t c = 0; c < output_rows; ++c)
        out.at(c, lane) = std::bit_cast<float>(arrangement.poison);
    }
    if (step == 0) call([&](const Batch& batch) { program.start(batch); });
    call([&](const Batch& batch) { program.step(batch); });
    if (!in.guards_stand() || !memory.guards_stand() || !out.guards_stand())
      throw std::runtime_error("writes outside the rows and lanes of its batch");
    if (program.memory_per_cell() != memory_rows)
      throw std::runtime_error("memory_per_cell changes");
    check_outputs(out, arrangement);
    for (std::uint32_t cell = 0; cell < cells; ++cell) {
      const std::uint32_t lane = arrangement.lane_of[cell];
      const auto keep = [&](float v) { became[cell].push_back(std::bit_cast<std::uint32_t>(v)); };
      for (std::uint32_t c = 0; c < output_rows; ++c) keep(out.at(c, lane));
      for (std::uint32_t r = 0; r < memory_rows; ++r) keep(memory.at(r, lane));
    }
  }
  return became;
}

inline void ProgramCheck::check_outputs(GuardedRows& out, const Arrangement& arrangement) const {
  for (std::uint32_t c = 0; c < layout_.outputs.size(); ++c)
    for (std::uint32_t lane = 0; lane < options_.lanes; ++lane) {
      const float value = out.at(c, lane);
      if (!std::isnan(value)) continue;
      const bool untouched = std::bit_cast<std::uint32_t>(value) == arrangement.poison;
      throw std::runtime_error("the output '" + std::string(layout_.outputs[c].name) +
                               (untouched ? "' is left unwritten" : "' becomes NaN"));
    }
}

inline void ProgramCheck::arrangements(Failures& failures, const std::string& of,
                                       const Program& program, std::uint16_t state,
                                       const PerCell& expected) const {
  const auto check = [&](const std::string& what, const Arrangement& arrangement) {
    attempt(failures, what + of, [&] {
      if (life(program, state, arrangement) != expected)
        throw std::runtime_error("outputs or memory of a cell differ");
    });
  };
  check("a second run of one program", straight());

  Arrangement permuted = straight();
  Rng rng(options_.heritable.seed, 0, 0, stable_key("lanes"), 0);
  for (std::size_t i = permuted.lane_of.size(); i > 1; --i)
    std::swap(permuted.lane_of[i - 1], permuted.lane_of[rng.below(i)]);
  check("cells in other lanes", permuted);

  Arrangement split = straight();
  split.batches = {1, 2};
  for (std::uint32_t left = options_.lanes - 3; left > 0; left -= split.batches.back())
    split.batches.push_back(std::min(left, 8u));
  check("a batch split into smaller ones", split);
  split.last_first = true;
  check("smaller batches in reverse", split);
  split.last_first = false;
  split.threads = true;
  check("smaller batches on several threads", split);

  Arrangement elsewhere = straight();
  elsewhere.guard = std::numeric_limits<float>::quiet_NaN();
  check("other values beyond the lanes", elsewhere);
  Arrangement filled = straight();
  filled.poison = std::bit_cast<std::uint32_t>(0.625f);
  check("other values in the outputs before a step", filled);
}

/// The same genes in another instance, whatever it has expressed before.
inline void ProgramCheck::expressed_again(std::uint64_t number, std::uint16_t state,
                                          const PerCell& expected) const {
  const std::unique_ptr<Controller> other = make_();
  static_cast<void>(other->express(genes(*other, number + 1), layout_));
  const std::unique_ptr<Program> program = other->express(genes(*other, number), layout_);
  if (life(*program, state, straight()) != expected)
    throw std::runtime_error("outputs or memory of a cell differ");
}

inline void ProgramCheck::run(Failures& failures, const std::string& of) const {
  const std::unique_ptr<Controller> controller = make_();
  for (std::uint64_t number = 0; number < options_.programs; ++number) {
    const auto state = static_cast<std::uint16_t>(number % layout_.states.size());
    std::unique_ptr<Program> program;
    PerCell expected;
    const auto first_run = [&] {
      program = controller->express(genes(*controller, number), layout_);
      if (!program) throw std::runtime_error("express returns nothing");
      expected = life(*program, state, straight());
    };
    const std::size_t before = failures.size();
    if (attempt(failures, "step" + of, first_run)) {
      arrangements(failures, of, *program, state, expected);
      attempt(failures, "express by a second instance" + of,
              [&] { expressed_again(number, state, expected); });
    }
    // One genome that fails says enough.
    if (failures.size() > before) return;
  }
}

}  // namespace detail

/// Whether controllers made by `make` keep the contract of controller.hpp: the laws of their genes
/// (see check_heritable), and of the programs that they express. A program hangs on its genes and
/// layout alone; no lane depends on another, on its place, on how cells are grouped into batches or
/// on threads; every output is written, none becomes NaN; nothing outside the batch is read or
/// written; memory_per_cell stays. `options.lanes` must be at least 4.
[[nodiscard]] inline Failures check_controller(const MakeController& make,
                                               const ControllerOptions& options = {}) {
  Failures failures;
  const std::vector<PortTable> usual = usual_ports();
  std::vector<Layout> layouts = options.layouts;
  if (layouts.empty())
    for (const PortTable& table : usual) layouts.push_back(table.layout());

  detail::attempt(failures, "constructor", [&] {
    const std::unique_ptr<Controller> controller = make();
    failures = check_heritable(controller->heritable(), layouts, options.heritable);
    for (std::size_t l = 0; l < layouts.size(); ++l)
      detail::ProgramCheck(make, layouts[l], options)
          .run(failures, " (layout " + std::to_string(l) + ")");
  });
  return failures;
}

/// The same for a plugin class and its parameters.
template <class C>
[[nodiscard]] Failures check_controller(
    const typename C::Parameters& parameters = typename C::Parameters(),
    const ControllerOptions& options = {}) {
  return check_controller([&] { return std::make_unique<C>(parameters); }, options);
}

}  // namespace somas::testing
