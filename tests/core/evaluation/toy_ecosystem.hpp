// A small world of its own: one state, cells that do what their genes say without looking, and a
// reaper who takes some of them by chance. Lives take some tens of steps.
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "core/model/ecosystem.hpp"
#include "tests/core/evolution/toy_heritable.hpp"

namespace somas::test {

/// Every cell dies with this probability a step.
class Reaper final : public Environment {
 public:
  Reaper(double probability, std::optional<std::uint64_t> failing_step)
      : probability_(probability), failing_step_(failing_step) {}
  void declare(Declare& declare) override {
    declare.acts_in(Phase::stress);
    cause_ = declare.cause("reaped");
    purpose_ = declare.purpose("reap");
  }
  void act(Phase, World& world) const override {
    if (world.step() == failing_step_) {
      ++failures;
      throw std::runtime_error("the scythe is blunt");
    }
    for (std::uint32_t cell = 0; cell < world.cells().count; ++cell)
      if (world.rng(purpose_, world.cells().id[cell]).chance(probability_))
        world.kill(cell, cause_);
  }

  inline static std::atomic<int> failures = 0;  ///< of all instances

 private:
  double probability_;
  std::optional<std::uint64_t> failing_step_;
  Id cause_ = no_id, purpose_ = no_id;
};

class OneState final : public Specialization {
 public:
  void grow(GenesView, std::span<const SkillInfo> skills, TreeSink& tree) const override {
    std::vector<double> points;
    for (const SkillInfo& skill : skills) points.push_back(skill.spec.fallback);
    points[0] = 5;  // capacity
    StateSpec state;
    state.name = "only";
    state.skills = points;
    tree.add(state);
  }
};

/// Constant outputs: a gene each, in percent. A first gene of 255 cannot be expressed.
class Stubborn final : public Controller {
 public:
  [[nodiscard]] const Heritable& heritable() const override { return heritable_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes, const Layout&) const override {
    if (genes[0] == 255) throw std::runtime_error("poison in gene " + std::to_string(genes[1]));
    return std::make_unique<Constant>(genes);
  }

 private:
  class Constant final : public Program {
   public:
    explicit Constant(GenesView genes) : genes_(genes.begin(), genes.end()) {}
    [[nodiscard]] std::uint32_t memory_per_cell() const override { return 0; }
    void step(const Batch& batch) const override {
      for (std::uint32_t c = 0; c < batch.out.channels; ++c)
        for (float& value : batch.out.channel(c)) value = static_cast<float>(genes_[c]) / 100.0f;
    }

   private:
    Genes genes_;
  };
  ToyHeritable heritable_;
};

class Survival final : public Fitness {
 public:
  explicit Survival(bool broken = false) : broken_(broken) {}
  [[nodiscard]] std::string_view objective() const override { return "longevity"; }
  [[nodiscard]] double score(const Outcome& outcome) const override {
    if (broken_) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(outcome.survival);
  }

 private:
  bool broken_;
};

struct ToyOptions {
  double reaping = 0.05;
  bool broken_fitness = false;
  std::uint64_t max_steps = 500;
  std::optional<std::uint64_t> failing_step{};
};

inline std::shared_ptr<const model::Ecosystem> toy_ecosystem(const ToyOptions& options = {}) {
  model::Config config;
  config.max_steps = options.max_steps;
  config.max_cells = 30;
  config.morphogens.size = 9;
  config.morphogens.kinds = {{0.1, 0.05}};
  return std::make_shared<const model::Ecosystem>(
      config,
      std::vector<model::NamedEnvironment>{
          {"reaper", std::make_shared<Reaper>(options.reaping, options.failing_step)}},
      std::make_shared<OneState>(), std::make_shared<Stubborn>(),
      std::make_shared<Survival>(options.broken_fitness));
}

/// Genes that fit the toy ecosystem, drawn from a stream.
inline model::Genome toy_genome(const model::Ecosystem& ecosystem, std::uint64_t number) {
  Rng rng(99, 0, 0, 0, number);
  model::Genome genome;
  ecosystem.controller().heritable().random(ecosystem.fixed_ports()->layout(), rng,
                                            genome.controller);
  return genome;
}

}  // namespace somas::test
