#include "core/conformance/timing.hpp"

#include <cstdio>
#include <vector>

#include "somas/sdk/testing.hpp"

namespace somas::conformance {
namespace {

constexpr std::uint32_t cells = 1000;
constexpr std::uint32_t steps = 50;
constexpr WorldInfo info{.radius = 60, .max_steps = 3000, .substeps = 3, .time_step = 1.0 / 30};

std::string text_of(double seconds, double count, const char* each) {
  char text[128];
  std::snprintf(text, sizeof text, "%.3g %s", seconds / count, each);
  return text;
}

std::string per_cell(double seconds) {
  return text_of(1e9 * seconds, double{cells} * steps,
                 "ns a cell and step, with 1000 cells of two organisms");
}

/// Many cells that neither divide nor die.
testing::Script crowd() {
  testing::Script script;
  script.birth_every = script.death_every = 0;
  Rng rng(1, 0, 0, stable_key("crowd"), 0);
  script.founders.clear();
  for (std::uint32_t i = 0; i < cells; ++i) {
    testing::TestCell cell{.id = i,
                           .organism = static_cast<std::uint16_t>(i % 2),
                           .state = static_cast<std::uint16_t>(i % 3)};
    cell.x = rng.uniform(-30, 30);
    cell.y = rng.uniform(-30, 30);
    script.founders.push_back(cell);
  }
  return script;
}

void live(testing::TestWorld& world, const Fitness* fitness) {
  world.begin();
  while (world.step() < steps) {
    world.advance();
    if (fitness != nullptr) static_cast<void>(fitness->observe(world));
  }
}

}  // namespace

std::string time_of_environment(const Making& making, const Taps& taps) {
  testing::EnvironmentOptions options;
  options.instance = making.plugin.id();
  options.script = crowd();
  options.variables = taps;
  const testing::EnvironmentStage stage(make_environment(making), options);
  const auto world = stage.world(1);
  const double before = seconds_in_steps();
  live(*world, nullptr);
  return per_cell(seconds_in_steps() - before);
}

std::string time_of_fitness(const Making& making) {
  testing::Declared declared;
  const std::unique_ptr<Fitness> fitness = make_fitness(making);
  testing::TestDeclare declare(declared, info, making.plugin.id());
  fitness->declare(declare);
  testing::TestWorld world(info, declared, 1, crowd(), {});
  const double before = seconds_in_steps();
  live(world, fitness.get());
  return per_cell(seconds_in_steps() - before);
}

std::string time_of_controller(const Making& making) {
  const testing::PortTable ports = std::move(testing::usual_ports()[1]);
  const Layout layout = ports.layout();
  const std::unique_ptr<Controller> controller = make_controller(making);
  Rng rng(1, 0, 0, stable_key("timing"), 0);
  Genes genes;
  controller->heritable().random(layout, rng, genes);
  const std::unique_ptr<Program> program = controller->express(genes, layout);

  const auto rows = [](std::size_t count) { return std::vector<float>(count * cells, 0.5f); };
  const auto outputs = static_cast<std::uint32_t>(layout.outputs.size());
  std::vector<float> in = rows(layout.input_channels), out = rows(outputs);
  std::vector<float> memory(std::size_t{program->memory_per_cell()} * cells, 0.0f);
  Batch batch;
  batch.count = cells;
  batch.in = {in.data(), layout.input_channels, cells, cells};
  batch.memory = {memory.data(), program->memory_per_cell(), cells, cells};
  batch.out = {out.data(), outputs, cells, cells};
  program->start(batch);
  const double before = seconds_in_steps();
  for (std::uint32_t i = 0; i < steps; ++i) program->step(batch);
  return text_of(1e9 * (seconds_in_steps() - before), double{cells} * steps,
                 "ns a cell and step, random genes, 1000 cells of one state");
}

std::string time_of_specialization(const Making& making, std::span<const SkillInfo> skills) {
  const std::unique_ptr<Specialization> tree = make_specialization(making);
  tree->declare(skills);
  Genes genes;
  Rng rng(1, 0, 0, stable_key("timing"), 0);
  if (const Heritable* heritable = tree->heritable()) heritable->random({}, rng, genes);
  const double before = seconds_in_steps();
  for (std::uint32_t i = 0; i < steps; ++i) {
    testing::TestTreeSink sink(skills);
    tree->grow(genes, skills, sink);
  }
  return text_of(1e6 * (seconds_in_steps() - before), steps, "us a tree");
}

}  // namespace somas::conformance
