// The world as plugins see it: the host's side of the SDK's World.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "somas/sdk/workers.hpp"

#include "core/model/ecosystem.hpp"
#include "core/model/hits.hpp"
#include "core/model/mechanics.hpp"
#include "core/model/profile.hpp"
#include "core/model/team.hpp"
#include "core/model/world_state.hpp"

namespace somas::model {

/// Lets plugins share their work with a team.
class TeamWorkers final : public Workers {
 public:
  void use(Team* team) { team_ = team; }
  void share(std::uint32_t count, std::uint32_t least, Call call, void* context) override;
  [[nodiscard]] std::uint32_t threads() const override {
    return team_ == nullptr ? 1 : team_->threads();
  }

 private:
  Team* team_ = nullptr;
};

class WorldView final : public World {
 public:
  /// All must outlive it. Hits are found among the cells as `mechanics` left them.
  WorldView(const Ecosystem& ecosystem, WorldState& state, FloatMatrix& inputs,
            MechanicsSolver& mechanics);

  /// Calls the environments that act in `phase`, in the experiment's order. Throws PluginFailure,
  /// also for sensors and forces that are not finite numbers.
  void act(Phase phase);
  /// Shares the search for first hits, and what plugins share, with `team` (null: nobody) from now
  /// on.
  void use(Team* team) {
    team_ = team;
    workers_.use(team);
  }
  /// Measures the calls of plugins from now on into `profile`, which may be null.
  void measure(Profile* profile) { profile_ = profile; }
  /// Accumulators for Phase::forces.
  void set_forces(std::span<double> fx, std::span<double> fy) { fx_ = fx, fy_ = fy; }
  /// Calls `begin` of every environment.
  void begin();
  /// Asks the fitness; true: stop.
  [[nodiscard]] bool observe();

  [[nodiscard]] void* extension(std::string_view id) const override;
  [[nodiscard]] std::uint64_t step() const override { return state_.step; }
  [[nodiscard]] const WorldInfo& info() const override { return ecosystem_.info(); }
  [[nodiscard]] const Cells& cells() const override { return cells_; }
  [[nodiscard]] std::span<float> sensor(Id sensor) override;
  [[nodiscard]] std::span<const double> skill(Id skill) override;
  [[nodiscard]] std::span<double> cell_value(Id value) override;
  [[nodiscard]] double& scalar(Id scalar) override;
  [[nodiscard]] Grid grid(Id grid) override;
  [[nodiscard]] Table& table(Id table) override;
  [[nodiscard]] std::span<double> force_x() override;
  [[nodiscard]] std::span<double> force_y() override;
  void first_hit(std::span<const Segment> segments, std::span<std::int32_t> cells) override;
  void strike(std::uint32_t cell, Id hazard, double energy) override;
  void kill(std::uint32_t cell, Id cause) override;
  [[nodiscard]] Rng rng(Id purpose, std::uint64_t entity) const override;
  [[nodiscard]] double parameter(Id parameter) const override;
  void set_parameter(Id parameter, double value) override;

 private:
  void refresh();
  void check_sensors(const std::string& instance) const;
  void check_forces() const;
  void require(Phase phase, const char* call) const;
  template <class Call>
  void guarded(const std::string& instance, const char* call, Call&& body);

  const Ecosystem& ecosystem_;
  WorldState& state_;
  FloatMatrix& inputs_;
  MechanicsSolver& mechanics_;
  Cells cells_;
  std::optional<Phase> phase_;
  const std::string* acting_ = nullptr;  ///< the instance that acts
  std::span<double> fx_, fy_;
  std::vector<std::uint64_t> purpose_keys_;  ///< by purpose Id
  HitFinder hits_;
  bool hits_ready_ = false;
  std::vector<std::vector<double>> skills_;  ///< scratch by skill; valid where filled
  std::vector<bool> skill_filled_;
  Profile* profile_ = nullptr;
  Team* team_ = nullptr;
  mutable TeamWorkers workers_;  ///< handed out by const `extension`
};

}  // namespace somas::model
