#include "core/model/profile.hpp"

#include <algorithm>

namespace somas::model {

std::string_view name_of(StepPhase phase) {
  static constexpr std::array<std::string_view, step_phases> names{
      "fields",  "sense",     "control", "decide", "metabolism", "cycle",
      "deposit", "mechanics", "stress",  "deaths", "observe"};
  return names[static_cast<std::size_t>(phase)];
}

Profile::Call& Profile::entry(std::string_view plugin, std::string_view call) {
  const auto known = std::find_if(calls_.begin(), calls_.end(), [&](const Call& c) {
    return c.plugin == plugin && c.call == call;
  });
  if (known != calls_.end()) return *known;
  return calls_.emplace_back(Call{std::string(plugin), std::string(call)});
}

void Profile::add_call(std::string_view plugin, std::string_view call, Duration time,
                       std::uint64_t calls) {
  Call& of = entry(plugin, call);
  of.time += time;
  of.calls += calls;
}

void Profile::add_life(Duration total, std::uint64_t steps, double cell_steps) {
  total_ += total;
  ++lives_;
  steps_ += steps;
  cell_steps_ += cell_steps;
}

void Profile::add(const Profile& other) {
  for (std::size_t p = 0; p < step_phases; ++p) phases_[p] += other.phases_[p];
  for (const Call& call : other.calls_) {
    Call& of = entry(call.plugin, call.call);
    of.time += call.time;
    of.calls += call.calls;
  }
  total_ += other.total_;
  lives_ += other.lives_;
  steps_ += other.steps_;
  cell_steps_ += other.cell_steps_;
}

}  // namespace somas::model
