// Sees a whole life: what happens within its steps, the world after each of them, and its result.
#pragma once

#include <utility>
#include <vector>

#include "core/evaluation/evaluator.hpp"
#include "core/model/simulation.hpp"
#include "core/model/witness.hpp"

namespace somas::recording {

class LifeWitness : public model::Witness {
 public:
  /// After every step.
  virtual void observe(const model::Simulation& simulation) = 0;
  virtual void finish(const evaluation::Result& result) = 0;
};

/// Several that see the same life.
class LifeWitnesses final : public LifeWitness {
 public:
  /// They must outlive this.
  explicit LifeWitnesses(std::vector<LifeWitness*> all) : all_(std::move(all)) {}

  void observe(const model::Simulation& simulation) override {
    for (LifeWitness* one : all_) one->observe(simulation);
  }
  void finish(const evaluation::Result& result) override {
    for (LifeWitness* one : all_) one->finish(result);
  }
  void controlled(const model::WorldState& world, const model::FloatMatrix& inputs,
                  const model::FloatMatrix& outputs) override {
    for (LifeWitness* one : all_) one->controlled(world, inputs, outputs);
  }
  void division_refused(const model::WorldState& world, std::uint32_t cell) override {
    for (LifeWitness* one : all_) one->division_refused(world, cell);
  }
  void ambrosia_passed(const model::WorldState& world, std::uint32_t from, std::uint32_t to,
                       double amount) override {
    for (LifeWitness* one : all_) one->ambrosia_passed(world, from, to, amount);
  }
  void specialized(const model::WorldState& world, std::uint32_t cell,
                   std::uint16_t from) override {
    for (LifeWitness* one : all_) one->specialized(world, cell, from);
  }
  void born(const model::WorldState& world, std::uint32_t daughter) override {
    for (LifeWitness* one : all_) one->born(world, daughter);
  }
  void died(const model::WorldState& world, std::uint32_t cell) override {
    for (LifeWitness* one : all_) one->died(world, cell);
  }

 private:
  std::vector<LifeWitness*> all_;
};

}  // namespace somas::recording
