#include "core/conformance/host_world.hpp"

#include <set>
#include <stdexcept>
#include <string>

#include "core/conformance/companions.hpp"
#include "core/evolution/heredity.hpp"
#include "core/model/simulation.hpp"
#include "core/model/snapshot.hpp"

namespace somas::conformance {
namespace {

using model::Ecosystem;
using model::Simulation;

/// Long enough for several divisions.
constexpr std::uint64_t steps = 120;
constexpr std::uint64_t genomes = 3;

model::Config small_world() {
  model::Config config;
  config.max_steps = steps;
  config.max_cells = 60;
  config.morphogens.size = 33;
  return config;
}

/// The hash of the world after every step.
using Life = std::vector<std::uint64_t>;

/// The worlds of one experiment, a founder of random genes in each.
class Worlds {
 public:
  Worlds(Making making, Taps taps) : making_(std::move(making)), taps_(std::move(taps)) {}

  /// Lived when they are first asked for.
  const std::vector<Life>& lives() {
    while (lives_.size() < genomes) lives_.push_back(live(*ecosystem(), lives_.size()));
    return lives_;
  }
  void again() {
    // Another instance, which has served another world before.
    const std::shared_ptr<const Ecosystem> other = wired(making_, taps_);
    static_cast<void>(live(*other, 1));
    require_same(lives()[0], live(*other, 0));
  }
  void in_turns() {
    const World first(*ecosystem(), 0), second(*ecosystem(), 1);
    Life of_first, of_second;
    while (advance(*first.simulation, of_first) | advance(*second.simulation, of_second)) {
    }
    require_same(lives()[0], of_first);
    require_same(lives()[1], of_second);
  }
  void saved() {
    for (std::uint64_t number = 0; number < genomes; ++number) {
      World world(*ecosystem(), number);
      Life life;
      while (life.size() < lives()[number].size() / 2) advance(*world.simulation, life);
      const std::vector<std::byte> bytes = model::save(*world.simulation);
      const std::shared_ptr<const Ecosystem> other = wired(making_, taps_);
      const model::Phenotype phenotype = other->express(genome(*other, number));
      const model::Phenotype* const roster[] = {&phenotype};
      Simulation restored(*other, roster, bytes);
      while (advance(restored, life)) {
      }
      require_same(lives()[number], life);
    }
  }

 private:
  struct World {
    World(const Ecosystem& ecosystem, std::uint64_t number)
        : phenotype(ecosystem.express(genome(ecosystem, number))) {
      const model::RosterEntry entry{&phenotype, number, 0, 0};
      simulation = std::make_unique<Simulation>(ecosystem, std::span(&entry, 1), number + 1);
    }
    model::Phenotype phenotype;
    std::unique_ptr<Simulation> simulation;
  };

  static model::Genome genome(const Ecosystem& ecosystem, std::uint64_t number) {
    const evolution::Heredity heredity(ecosystem);
    Rng rng(1, 0, 0, stable_key("host world"), number);
    model::Genome genome = heredity.random(rng);
    for (std::uint64_t i = 0; i < 10 * number; ++i) heredity.mutate(genome, rng);
    return genome;
  }
  /// One step; false when there is none to come.
  static bool advance(Simulation& simulation, Life& life) {
    if (simulation.finished()) return false;
    const std::uint64_t before = simulation.steps_done();
    const bool more = simulation.step();
    if (simulation.steps_done() != before) life.push_back(simulation.hash());
    return more;
  }
  static Life live(const Ecosystem& ecosystem, std::uint64_t number) {
    const World world(ecosystem, number);
    Life life;
    while (advance(*world.simulation, life)) {
    }
    for (const Outcome& outcome : world.simulation->outcomes())
      static_cast<void>(ecosystem.fitness().score(outcome));
    return life;
  }
  static void require_same(const Life& expected, const Life& other) {
    for (std::size_t i = 0; i < std::min(expected.size(), other.size()); ++i)
      if (expected[i] != other[i])
        throw std::runtime_error("the world differs after step " + std::to_string(i));
    if (expected.size() != other.size())
      throw std::runtime_error("a life of " + std::to_string(other.size()) + " steps, not " +
                               std::to_string(expected.size()));
  }
  const std::shared_ptr<const Ecosystem>& ecosystem() {
    if (!ecosystem_) ecosystem_ = wired(making_, taps_);
    return ecosystem_;
  }

  Making making_;
  Taps taps_;
  std::shared_ptr<const Ecosystem> ecosystem_;
  std::vector<Life> lives_;
};

}  // namespace

std::shared_ptr<const Ecosystem> wired(const Making& making, const Taps& taps) {
  Making plain = making;
  plain.names_calls = false;  // the host names them
  const bool tree_examined = making.plugin.info->kind == PluginKind::specialization;
  std::vector<model::NamedEnvironment> environments = {
      {"companion", std::make_shared<CompanionMeadow>(tree_examined)}};
  std::set<std::string> instances;
  for (const auto& tap : taps)
    if (instances.insert(tap.instance).second)
      environments.push_back({tap.instance, std::make_shared<CompanionTaps>(taps)});
  std::shared_ptr<Specialization> tree = std::make_shared<CompanionTree>();
  std::shared_ptr<Controller> controller = std::make_shared<CompanionController>();
  std::shared_ptr<Fitness> fitness = std::make_shared<CompanionFitness>();
  switch (making.plugin.info->kind) {
    case PluginKind::environment:
      environments.push_back({making.plugin.id(), make_environment(plain)});
      break;
    case PluginKind::specialization:
      tree = make_specialization(plain);
      break;
    case PluginKind::controller:
      controller = make_controller(plain);
      break;
    case PluginKind::fitness:
      fitness = make_fitness(plain);
      break;
  }
  return std::make_shared<const Ecosystem>(small_world(), std::move(environments), std::move(tree),
                                           std::move(controller), std::move(fitness));
}

testing::Checks host_checks(const Making& making, const Taps& taps) {
  const auto worlds = std::make_shared<Worlds>(making, taps);
  const char* alone = "see what the checks above say; what changes belongs in the World";
  const std::string lives = "the host: lives", again = "the host: the same seed twice",
                    in_turns = "the host: two worlds in turns";
  return {{.law = lives,
           .name = lives,
           .remedy = "see the call that is named; what it throws ends a run",
           .body = [worlds] { static_cast<void>(worlds->lives()); },
           .first = true},
          {.law = again, .name = again, .remedy = alone, .body = [worlds] { worlds->again(); }},
          {.law = in_turns,
           .name = in_turns,
           .remedy = alone,
           .body = [worlds] { worlds->in_turns(); },
           .needs = {again}},
          {.law = "the host: saved and restored",
           .name = "the host: saved and restored",
           .remedy = alone,
           .body = [worlds] { worlds->saved(); },
           .needs = {again, in_turns}}};
}

}  // namespace somas::conformance
