#include "core/evaluation/canary.hpp"

#include <cstdio>

#include "core/evolution/heredity.hpp"
#include "core/model/call_site.hpp"
#include "core/model/simulation.hpp"

namespace somas::evaluation {
namespace {

constexpr std::uint64_t canary_steps = 48;

}  // namespace

std::string canary_hash(const model::Ecosystem& ecosystem, std::uint32_t number) {
  const evolution::Heredity heredity(ecosystem);
  Rng rng(number, 0, 0, stable_key("canary"), 0);
  const model::Genome genome = heredity.random(rng);
  const model::Phenotype phenotype = ecosystem.express(genome);
  const model::RosterEntry entry{&phenotype, 1, 0, 0};

  model::Simulation simulation(ecosystem, {&entry, 1}, number);
  // Each step counts: a difference may die with the cell that bore it.
  std::uint64_t sum = simulation.hash();
  bool more = true;
  while (more && simulation.steps_done() < canary_steps) {
    model::note_progress();
    more = simulation.step();
    sum = sum * 0x9E3779B97F4A7C15u + simulation.hash();
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(sum));
  return text;
}

}  // namespace somas::evaluation
