#include "core/conformance/companions.hpp"

#include <algorithm>
#include <cmath>

namespace somas::conformance {
namespace {

constexpr std::string_view food = "companion_food";

class CompanionProgram final : public Program {
 public:
  explicit CompanionProgram(const Layout& layout) : weights_(layout.outputs.size()) {
    // A name's key as a number in [0, 1); what makes a life comes first.
    for (const Port& port : layout.outputs) {
      double weight = 0x1p-32 * static_cast<double>(stable_key(port.name) >> 32);
      if (port.name == "division") weight = 0.95;
      if (port.name == "apoptosis") weight = 0.05;
      if (port.name == "quiescence") weight = 0.4;
      if (port.name.starts_with("uptake.")) weight = 1;
      weights_[port.channel] = static_cast<float>(weight);
    }
    for (const Port& port : layout.inputs)
      if (port.name.find("energy") != std::string_view::npos && port.state == 0)
        energy_ = port.channel;
  }
  [[nodiscard]] std::uint32_t memory_per_cell() const override { return 0; }
  void step(const Batch& batch) const override {
    const std::span<const float> energy = batch.in.channel(energy_);
    const float share = 0.2f / static_cast<float>(batch.in.channels);
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      // Everything that is sensed counts.
      float drive = 0.4f + 0.4f * energy[i];
      for (std::uint32_t c = 0; c < batch.in.channels; ++c) drive += share * batch.in.channel(c)[i];
      for (std::uint32_t c = 0; c < batch.out.channels; ++c)
        batch.out.channel(c)[i] = weights_[c] * drive;
    }
  }

 private:
  std::vector<float> weights_;
  std::uint32_t energy_ = 0;
};

}  // namespace

void CompanionMeadow::declare(Declare& declare) {
  constexpr double side = 4;
  const double half = std::ceil(declare.world().radius / side) * side;
  const auto squares = static_cast<std::uint32_t>(2 * half / side);
  grid_ = declare.grid(food, {.columns = squares,
                              .rows = squares,
                              .side = side,
                              .left = -half,
                              .bottom = -half,
                              .initial = 2});
  declare.resource(food, grid_, declare.skill("companion_production", {.fallback = 2}));
  if (with_usual_skills_)
    for (const std::string_view name : usual_skills) static_cast<void>(declare.skill(name, {}));
  declare.acts_in(Phase::fields);
}

void CompanionMeadow::act(Phase, World& world) const {
  for (double& content : world.grid(grid_).values) content = std::min(2.0, content + 0.1);
}

void CompanionTaps::declare(Declare& declare) {
  for (const testing::EnvironmentOptions::OfOthers& tap : taps_)
    if (tap.instance == declare.instance())
      static_cast<void>(declare.parameter(tap.name, tap.spec));
}

void CompanionTree::grow(GenesView, std::span<const SkillInfo> skills, TreeSink& tree) const {
  StateSpec state;
  for (std::uint16_t i = 0; i < 2; ++i) {
    std::vector<double> points;
    for (const SkillInfo& skill : skills) {
      const double wanted = skill.name == "capacity" ? 10 : skill.spec.fallback + i;
      points.push_back(std::clamp(wanted, skill.spec.minimum, skill.spec.maximum));
    }
    state.name = i == 0 ? "root" : "child";
    state.parent = i == 0 ? no_state : std::uint16_t{0};
    state.skills = points;
    tree.add(state);
  }
}

std::unique_ptr<Program> CompanionController::express(GenesView, const Layout& layout) const {
  return std::make_unique<CompanionProgram>(layout);
}

}  // namespace somas::conformance
