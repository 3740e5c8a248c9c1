#include "core/report/picture.hpp"

#include <algorithm>

#include "core/plugins/suggest.hpp"
#include "core/report/painter.hpp"
#include "core/run/errors.hpp"

namespace somas::report {

Picture::Picture(PictureOptions options)
    : options_(std::move(options)), wants_{.grid = options_.grid} {
  std::vector<std::uint64_t>& steps = options_.steps;
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  if (steps.empty()) throw run::UsageError("a picture needs at least one step");
  if (options_.width / steps.size() < least_panel_width)
    throw run::UsageError("a picture of " + plugins::plural(steps.size(), "step") +
                          " needs a width of at least " +
                          std::to_string(steps.size() * least_panel_width));
}

void Picture::observe(const model::Simulation& simulation) {
  if (!described_) setting_ = setting_of(simulation, wants_);
  described_ = true;
  last_step_ = simulation.state().step - 1;
  if (std::binary_search(options_.steps.begin(), options_.steps.end(), last_step_))
    panels_.push_back(scene_of(simulation, setting_, wants_));
}

void Picture::check_complete() const {
  if (!described_) throw run::UsageError("--steps: no step was simulated");
  if (options_.steps.back() > last_step_)
    throw run::UsageError("--steps: step " + std::to_string(options_.steps.back()) +
                          " is beyond the life; its last step is " + std::to_string(last_step_));
  if (panels_.size() != options_.steps.size())
    throw run::UsageError("--steps: step " + std::to_string(options_.steps.front()) +
                          " comes before the step at which the replay begins");
}

std::string Picture::render(PictureFormat format) const {
  check_complete();
  return Painter(*this, format).paint();
}

}  // namespace somas::report
