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
  ProgramCheck(MakeController make, const Layout& layout, const ControllerOptions& options)
      : make_(std::move(make)), layout_(layout), options_(options), controller_(make_()) {}

  /// The checks, which keep `it`; `of` names the layout.
  [[nodiscard]] static Checks list(const std::shared_ptr<ProgramCheck>& it, const std::string& of);

 private:
  using PerCell = std::vector<std::vector<std::uint32_t>>;  ///< bits of all that a cell became
  static constexpr std::uint32_t most_memory = 100'000;     ///< numbers per cell, as in the host
  /// What one genome's program did, undisturbed.
  struct Life {
    std::unique_ptr<Program> program;
    std::uint16_t state = 0;
    PerCell became;
  };

  /// Lived when they are first asked for.
  [[nodiscard]] const std::vector<Life>& lives();
  [[nodiscard]] Genes genes(const Controller& controller, std::uint64_t number) const;
  [[nodiscard]] float input(std::uint32_t step, std::uint32_t channel, std::uint32_t cell) const;
  [[nodiscard]] PerCell life(const Program& program, std::uint16_t state,
                             const Arrangement& arrangement) const;
  void check_outputs(GuardedRows& out, const Arrangement& arrangement) const;
  [[nodiscard]] Arrangement straight() const;
  [[nodiscard]] Arrangement permuted() const;
  [[nodiscard]] Arrangement split() const;
  void arranged(const Arrangement& arrangement);
  void expressed_again();

  MakeController make_;
  Layout layout_;
  ControllerOptions options_;
  std::unique_ptr<Controller> controller_;  ///< outlives its programs
  std::vector<Life> lives_{};
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

inline Arrangement ProgramCheck::permuted() const {
  Arrangement a = straight();
  Rng rng(options_.heritable.seed, 0, 0, stable_key("lanes"), 0);
  for (std::size_t i = a.lane_of.size(); i > 1; --i)
    std::swap(a.lane_of[i - 1], a.lane_of[rng.below(i)]);
  return a;
}

inline Arrangement ProgramCheck::split() const {
  Arrangement a = straight();
  a.batches = {1, 2};
  for (std::uint32_t left = options_.lanes - 3; left > 0; left -= a.batches.back())
    a.batches.push_back(std::min(left, 8u));
  return a;
}

inline const std::vector<ProgramCheck::Life>& ProgramCheck::lives() {
  while (lives_.size() < options_.programs) {
    const std::uint64_t number = lives_.size();
    Life life;
    life.state = static_cast<std::uint16_t>(number % layout_.states.size());
    life.program = controller_->express(genes(*controller_, number), layout_);
    if (!life.program) throw std::runtime_error("express returns nothing");
    if (life.program->memory_per_cell() > most_memory)
      throw std::runtime_error(
          "the program wants " + std::to_string(life.program->memory_per_cell()) +
          " numbers of memory per cell; the host allows " + std::to_string(most_memory));
    life.became = this->life(*life.program, life.state, straight());
    lives_.push_back(std::move(life));
  }
  return lives_;
}

/// All programs again, their cells arranged otherwise.
inline void ProgramCheck::arranged(const Arrangement& arrangement) {
  for (const Life& first : lives())
    if (life(*first.program, first.state, arrangement) != first.became)
      throw std::runtime_error("outputs or memory of a cell differ");
}

/// The same genes in another instance, whatever it has expressed before.
inline void ProgramCheck::expressed_again() {
  for (std::uint64_t number = 0; number < lives().size(); ++number) {
    const std::unique_ptr<Controller> other = make_();
    static_cast<void>(other->express(genes(*other, number + 1), layout_));
    const std::unique_ptr<Program> program = other->express(genes(*other, number), layout_);
    if (life(*program, lives_[number].state, straight()) != lives_[number].became)
      throw std::runtime_error("outputs or memory of a cell differ");
  }
}

inline Checks ProgramCheck::list(const std::shared_ptr<ProgramCheck>& it, const std::string& of) {
  Checks checks;
  const std::string again = "a second run of one program";
  const auto add = [&](const std::string& law, const char* remedy, std::vector<std::string> needs,
                       std::function<void()> body) {
    checks.push_back({.law = law,
                      .name = law + of,
                      .remedy = remedy,
                      .body = std::move(body),
                      .needs = std::move(needs),
                      .scope = "program" + of});
  };
  const auto add_arranged = [&](const std::string& law, const char* remedy,
                                std::vector<std::string> needs, const Arrangement& arrangement) {
    add(law, remedy, std::move(needs), [it, arrangement] { it->arranged(arrangement); });
  };
  add("step",
      "write every output of every lane, never NaN, and nothing beyond Batch::count lanes and the "
      "rows that there are",
      {}, [it] { static_cast<void>(it->lives()); });
  checks.back().first = true;
  add_arranged(again,
               "keep what changes in Batch::memory: no mutable members, statics or thread_locals",
               {}, it->straight());
  add_arranged("cells in other lanes", "no lane may depend on its place in the batch", {again},
               it->permuted());
  Arrangement split = it->split();
  add_arranged("a batch split into smaller ones",
               "no lane may depend on others, nor on how many there are; vector loops need the "
               "same arithmetic for the lanes that are left over",
               {again, "cells in other lanes"}, split);
  split.last_first = true;
  add_arranged("smaller batches in reverse",
               "no batch may depend on those before it: carry nothing from call to call",
               {again, "a batch split into smaller ones"}, split);
  split.last_first = false;
  split.threads = true;
  add_arranged("smaller batches on several threads",
               "step is called from several threads at once: write to the batch only",
               {again, "a batch split into smaller ones", "smaller batches in reverse"}, split);
  Arrangement elsewhere = it->straight();
  elsewhere.guard = std::numeric_limits<float>::quiet_NaN();
  add_arranged("other values beyond the lanes", "read Batch::count lanes of a row, and no more",
               {again}, elsewhere);
  Arrangement filled = it->straight();
  filled.poison = std::bit_cast<std::uint32_t>(0.625f);
  add_arranged("other values in the outputs before a step",
               "outputs hold anything before a step: write them before you read them", {again},
               filled);
  add("express by a second instance",
      "a program hangs on genes, layout and parameters alone: keep nothing from one express to the "
      "next",
      {again, "chance from the stream alone"}, [it] { it->expressed_again(); });
  return checks;
}

}  // namespace detail

/// The checks of check_controller, one by one. They make instances, so that what a constructor
/// throws is thrown here.
[[nodiscard]] inline Checks controller_checks(const MakeController& make,
                                              const ControllerOptions& options = {}) {
  struct Subject {
    std::vector<PortTable> usual = usual_ports();
    std::vector<Layout> layouts;
    std::unique_ptr<Controller> controller;
  };
  const auto subject = std::make_shared<Subject>();
  subject->layouts = options.layouts;
  if (subject->layouts.empty())
    for (const PortTable& table : subject->usual) subject->layouts.push_back(table.layout());
  subject->controller = make();

  Checks checks =
      heritable_checks(subject->controller->heritable(), subject->layouts, options.heritable);
  for (std::size_t l = 0; l < subject->layouts.size(); ++l)
    for (Check& check : detail::ProgramCheck::list(
             std::make_shared<detail::ProgramCheck>(make, subject->layouts[l], options),
             " (layout " + std::to_string(l) + ")"))
      checks.push_back(std::move(check));
  for (Check& check : checks) check.body = [subject, body = std::move(check.body)] { body(); };
  return checks;
}

/// Whether controllers made by `make` keep the contract of controller.hpp: the laws of their genes
/// (see check_heritable), and of the programs that they express. A program hangs on its genes and
/// layout alone; no lane depends on another, on its place, on how cells are grouped into batches or
/// on threads; every output is written, none becomes NaN; nothing outside the batch is read or
/// written; memory_per_cell stays. `options.lanes` must be at least 4.
[[nodiscard]] inline Failures check_controller(const MakeController& make,
                                               const ControllerOptions& options = {}) {
  Failures failures;
  detail::attempt(failures, "constructor",
                  [&] { failures = detail::run(controller_checks(make, options)); });
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
