// Whole simulations of a founder that rests, eats and never divides.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/model/simulation.hpp"
#include "core/model/team.hpp"
#include "plugins/fitness/survival_time/survival_time.hpp"
#include "plugins/specialization/tree/tree.hpp"

namespace somas::environments {

/// A controller without genes: rest, take up all, burn all.
class Resting final : public Controller, private Heritable {
 public:
  const Heritable& heritable() const override { return *this; }
  std::unique_ptr<Program> express(GenesView, const Layout& layout) const override {
    return std::make_unique<Rest>(layout);
  }

 private:
  class Rest final : public Program {
   public:
    explicit Rest(const Layout& layout) {
      for (const Port& port : layout.outputs)
        outputs_.push_back(port.name == "quiescence" || port.name == "conversion" ||
                           port.name.starts_with("uptake."));
    }
    std::uint32_t memory_per_cell() const override { return 0; }
    void step(const Batch& batch) const override {
      for (std::uint32_t c = 0; c < outputs_.size(); ++c)
        for (float& value : batch.out.channel(c)) value = outputs_[c] ? 1.0f : 0.0f;
    }

   private:
    std::vector<bool> outputs_;
  };

  void random(const Layout&, Rng&, Genes&) const override {}
  void conform(const Layout&, Rng&, Genes&) const override {}
  void mutate(const Layout&, Rng&, Genes&) const override {}
  void cross(const Layout&, GenesView, GenesView, Rng&, Genes&) const override {}
  double distance(GenesView, GenesView) const override { return 0; }
  void to_json(GenesView, JsonWriter&) const override {}
  void from_json(const JsonReader&, Genes&) const override {}
  void check(const Layout&, GenesView) const override {}
};

struct Ending {
  Outcome outcome;
  std::uint64_t hash;
  double x;  ///< of the first cell, if any lives
};

/// Shared by so many threads.
inline Ending live(std::vector<model::NamedEnvironment> environments,
                   std::map<std::string, double> skills, model::Config config = {},
                   std::uint64_t seed = 1, unsigned threads = 1) {
  specialization::Tree::State n;
  n.name = std::string("N");
  n.skills = std::move(skills);
  specialization::Tree::Parameters tree;
  tree.states.push_back(n);
  const model::Ecosystem ecosystem(
      std::move(config), std::move(environments), std::make_shared<specialization::Tree>(tree),
      std::make_shared<Resting>(),
      std::make_shared<fitness::SurvivalTime>(fitness::SurvivalTime::Parameters{}));
  const model::Phenotype phenotype = ecosystem.express({});
  const model::RosterEntry founder{&phenotype, 1, 0, 0};
  model::Simulation simulation(ecosystem, {&founder, 1}, seed);
  model::Team team(threads, 1);  // everything is worth a thread
  simulation.use(&team);
  simulation.run();
  const std::vector<double>& x = simulation.state().cells.x;
  return {simulation.outcomes()[0], simulation.hash(), x.empty() ? 0 : x[0]};
}

template <class Environment>
model::NamedEnvironment named(const char* name,
                              const typename Environment::Parameters& parameters) {
  return {name, std::make_shared<Environment>(parameters)};
}

/// With the defaults.
template <class Environment>
model::NamedEnvironment named(const char* name) {
  const typename Environment::Parameters parameters;
  return named<Environment>(name, parameters);
}

}  // namespace somas::environments
