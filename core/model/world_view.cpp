#include "core/model/world_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/model/call_site.hpp"

namespace somas::model {

namespace {

constexpr std::array<const char*, phase_count> phase_calls{
    "act(fields)", "act(sense)", "act(forces)", "act(stress)", "act(parameters)"};

/// The world's own random streams, apart from every organism's.
constexpr std::uint64_t world_stream = ~std::uint64_t{0};

template <class T>
bool finite(T value) {
  return std::isfinite(value);
}

const char* text_of(double value) {
  if (std::isnan(value)) return "NaN";
  return value > 0 ? "infinity" : "-infinity";
}

}  // namespace

void TeamWorkers::share(std::uint32_t count, std::uint32_t least, Call call, void* context) {
  if (count == 0) return;
  // `least` items are as much work as the cells that are worth a thread.
  const std::uint64_t cells =
      std::uint64_t{count} * cells_worth_a_thread / std::max(least, std::uint32_t{1});
  model::share(team_, count, cells, [&](std::uint32_t begin, std::uint32_t end) {
    if (begin < end) call(context, begin, end);
  });
}

void* WorldView::extension(std::string_view id) const {
  if (id == Workers::extension_id) return static_cast<Workers*>(&workers_);
  return nullptr;
}

WorldView::WorldView(const Ecosystem& ecosystem, WorldState& state, FloatMatrix& inputs,
                     MechanicsSolver& mechanics)
    : ecosystem_(ecosystem), state_(state), inputs_(inputs), mechanics_(mechanics) {
  for (const auto& purpose : ecosystem.schema().purposes)
    purpose_keys_.push_back(stable_key(purpose));
}

template <class Call>
void WorldView::guarded(const std::string& instance, const char* call, Call&& body) {
  const auto where = [&] { return std::string(call) + " at step " + std::to_string(state_.step); };
  const PluginCall here(instance, call, state_.step);
  const Stopwatch watch(profile_, [&](Profile& profile, Profile::Duration time) {
    profile.add_call(instance, call, time);
  });
  try {
    body();
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    throw PluginFailure(instance, where(), error.what());
  } catch (...) {
    throw PluginFailure(instance, where(), "an exception that is no std::exception");
  }
}

void WorldView::refresh() {
  const CellStore& c = state_.cells;
  cells_ = {.count = c.size(),
            .x = c.x,
            .y = c.y,
            .vx = c.vx,
            .vy = c.vy,
            .radius = c.radius,
            .energy = c.energy,
            .ambrosia = c.ambrosia,
            .pressure = c.pressure,
            .id = c.id,
            .state = c.state,
            .organism = c.organism,
            .dead = c.dead};
  skills_.resize(ecosystem_.schema().skills.size());
  skill_filled_.assign(skills_.size(), false);
  hits_ready_ = false;
}

void WorldView::act(Phase phase) {
  const std::vector<std::uint32_t>& acting = ecosystem_.acting(phase);
  if (acting.empty()) return;
  refresh();
  phase_ = phase;
  for (const std::uint32_t index : acting) {
    const NamedEnvironment& environment = ecosystem_.environments()[index];
    acting_ = &environment.name;
    guarded(environment.name, phase_calls[static_cast<std::size_t>(phase)], [&] {
      environment.instance->act(phase, *this);
      if (phase == Phase::sense) check_sensors(environment.name);
      if (phase == Phase::forces) check_forces();
    });
  }
  phase_.reset();
}

// Of the instance that has just acted: nobody else fills them.
void WorldView::check_sensors(const std::string& instance) const {
  const std::vector<Sensor>& sensors = ecosystem_.schema().sensors;
  const std::size_t first = ecosystem_.config().morphogens.kinds.size() + 3;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (sensors[s].owner != instance) continue;
    const float* values = inputs_.row(static_cast<std::uint32_t>(first + s));
    const float* end = values + state_.cells.size();
    if (const float* bad = std::find_if_not(values, end, finite<float>); bad != end)
      throw std::runtime_error("the sensor '" + sensors[s].name + "' of cell " +
                               std::to_string(state_.cells.id[bad - values]) + " is " +
                               text_of(*bad) + ", not a finite number");
  }
}

// The sum so far: it was finite before the instance that has just acted.
void WorldView::check_forces() const {
  for (const std::span<double> forces : {fx_, fy_})
    if (const auto bad = std::find_if_not(forces.begin(), forces.end(), finite<double>);
        bad != forces.end())
      throw std::runtime_error("the force on cell " +
                               std::to_string(state_.cells.id[bad - forces.begin()]) + " is " +
                               text_of(*bad) + ", not a finite number");
}

void WorldView::begin() {
  refresh();
  for (const NamedEnvironment& environment : ecosystem_.environments())
    guarded(environment.name, "begin", [&] { environment.instance->begin(*this); });
}

bool WorldView::observe() {
  refresh();
  bool stop = false;
  guarded("fitness", "observe", [&] { stop = ecosystem_.fitness().observe(*this); });
  return stop;
}

void WorldView::require(Phase phase, const char* call) const {
  if (phase_ != phase)
    throw std::logic_error(std::string(call) + " belongs in " +
                           phase_calls[static_cast<std::size_t>(phase)]);
}

std::span<float> WorldView::sensor(Id sensor) {
  require(Phase::sense, "sensor");
  const std::vector<Sensor>& sensors = ecosystem_.schema().sensors;
  if (sensor >= sensors.size()) throw std::logic_error("no such sensor");
  if (sensors[sensor].owner != *acting_)
    throw std::logic_error("the sensor '" + sensors[sensor].name + "' belongs to " +
                           sensors[sensor].owner);
  const auto channel = static_cast<std::uint32_t>(ecosystem_.config().morphogens.kinds.size()) + 3;
  return {inputs_.row(channel + sensor), state_.cells.size()};
}

std::span<const double> WorldView::skill(Id skill) {
  std::vector<double>& column = skills_.at(skill);
  if (!skill_filled_[skill]) {
    column.resize(state_.cells.size());
    for (const CellRange& range : state_.cells.ranges) {
      const double points = state_.state_of(range.begin).skill(skill);
      std::fill(column.begin() + range.begin, column.begin() + range.end, points);
    }
    skill_filled_[skill] = true;
  }
  return column;
}

std::span<double> WorldView::cell_value(Id value) { return state_.cells.values.at(value); }

double& WorldView::scalar(Id scalar) { return state_.scalars.at(scalar); }

Grid WorldView::grid(Id grid) {
  return {state_.grids.at(grid), ecosystem_.schema().grids[grid].spec};
}

Table& WorldView::table(Id table) { return state_.tables.at(table); }

std::span<double> WorldView::force_x() {
  require(Phase::forces, "force_x");
  return fx_;
}

std::span<double> WorldView::force_y() {
  require(Phase::forces, "force_y");
  return fy_;
}

void WorldView::first_hit(std::span<const Segment> segments, std::span<std::int32_t> cells) {
  require(Phase::stress, "first_hit");
  if (cells.size() < segments.size()) throw std::logic_error("first_hit: too few places for hits");
  if (!hits_ready_)
    hits_.prepare(mechanics_.bodies(), mechanics_.bins(), mechanics_.cells(), state_.cells.rank);
  hits_ready_ = true;
  hits_.expect(segments.size(), team_);
  // A path near the cells takes some three times as long as a cell in a phase of the step.
  share(team_, static_cast<std::uint32_t>(segments.size()), 3 * segments.size(),
        [&](std::uint32_t begin, std::uint32_t end) {
          hits_.first(segments.subspan(begin, end - begin), cells.subspan(begin, end - begin));
        });
}

void WorldView::strike(std::uint32_t cell, Id hazard, double energy) {
  require(Phase::stress, "strike");
  if (cell >= state_.cells.size()) throw std::logic_error("strike: no such cell");
  if (!(energy >= 0)) throw std::logic_error("strike: the energy must be a number, at least 0");
  const Hazard& declared = ecosystem_.schema().hazards.at(hazard);
  double& absorbed = state_.cells.damage[hazard][cell];
  absorbed += energy;
  if (absorbed > state_.state_of(cell).skill(declared.resistance_skill))
    state_.cells.kill(cell, declared.cause);
}

void WorldView::kill(std::uint32_t cell, Id cause) {
  require(Phase::stress, "kill");
  if (cell >= state_.cells.size()) throw std::logic_error("kill: no such cell");
  if (cause >= ecosystem_.schema().causes.size()) throw std::logic_error("kill: no such cause");
  state_.cells.kill(cell, cause);
}

Rng WorldView::rng(Id purpose, std::uint64_t entity) const {
  return {state_.seed, world_stream, state_.step, purpose_keys_.at(purpose), entity};
}

double WorldView::parameter(Id parameter) const { return state_.parameters.at(parameter); }

void WorldView::set_parameter(Id parameter, double value) {
  require(Phase::parameters, "set_parameter");
  const VariableParameter& p = ecosystem_.schema().parameters.at(parameter);
  if (p.in_charge != *acting_)
    throw std::logic_error("set_parameter: '" + p.owner + "." + p.name + "' is not in its charge");
  if (!(value >= p.spec.minimum && value <= p.spec.maximum))
    throw std::logic_error("set_parameter: '" + p.owner + "." + p.name + "' is out of its range");
  state_.parameters[parameter] = value;
}

}  // namespace somas::model
