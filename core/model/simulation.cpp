#include "core/model/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/model/call_site.hpp"
#include "core/model/ranges.hpp"

namespace somas::model {

Simulation::Simulation(const Ecosystem& ecosystem, std::span<const RosterEntry> roster,
                       std::uint64_t seed)
    : ecosystem_(ecosystem),
      view_(ecosystem, state_, inputs_, mechanics_),
      mechanics_(ecosystem.config().strangers) {
  state_.seed = seed;
  found(roster);
  const Schema& schema = ecosystem_.schema();
  for (const GridDeclaration& grid : schema.grids)
    state_.grids.emplace_back(std::size_t{grid.spec.columns} * grid.spec.rows, grid.spec.initial);
  for (const TableDeclaration& table : schema.tables)
    state_.tables.emplace_back(table.columns.size());
  for (const Scalar& scalar : schema.scalars) state_.scalars.push_back(scalar.initial);
  for (const VariableParameter& p : schema.parameters) state_.parameters.push_back(p.spec.value);
  view_.begin();
}

void Simulation::found(std::span<const RosterEntry> roster) {
  if (roster.empty()) throw std::invalid_argument("a roster needs an organism");
  if (roster.size() >= std::numeric_limits<std::uint16_t>::max())
    throw std::invalid_argument("a roster holds at most 65534 organisms");
  const Schema& schema = ecosystem_.schema();
  const Metabolism& start = ecosystem_.config().metabolism;

  // Organisms by ascending key, whatever their place in the roster.
  std::uint32_t memory_rows = 0;
  for (std::uint32_t r = 0; r < roster.size(); ++r) {
    OrganismState& organism = state_.organisms.emplace_back();
    organism.key = roster[r].key;
    organism.roster_index = r;
    organism.phenotype = roster[r].phenotype;
    organism.next_id = 1;
    organism.live = 1;
    organism.fields = MorphogenFields(ecosystem_.config().morphogens);
    organism.deaths.assign(schema.causes.size(), 0);
    memory_rows = std::max(memory_rows, organism.phenotype->program->memory_per_cell());
  }
  std::sort(state_.organisms.begin(), state_.organisms.end(),
            [](const auto& a, const auto& b) { return a.key < b.key; });
  for (std::size_t k = 1; k < state_.organisms.size(); ++k)
    if (state_.organisms[k].key == state_.organisms[k - 1].key)
      throw std::invalid_argument("the keys of a roster must differ");

  CellStore& cells = state_.cells;
  cells.values.resize(schema.cell_values.size());
  cells.damage.resize(schema.hazards.size());
  const auto organisms = static_cast<std::uint16_t>(state_.organisms.size());
  for (std::uint16_t k = 0; k < organisms; ++k) {
    OrganismState& organism = state_.organisms[k];
    const State& root = organism.phenotype->tree->states[0];
    const std::uint32_t i = cells.append(memory_rows);
    cells.organism[i] = k;
    cells.x[i] = roster[organism.roster_index].x;
    cells.y[i] = roster[organism.roster_index].y;
    cells.radius[i] = root.radius;
    cells.energy[i] = start.founder_energy;
    cells.ambrosia[i] = std::min(start.founder_ambrosia, root.skill(skill_capacity));
    organism.ledger.founder_energy = cells.energy[i];
    organism.ledger.founder_ambrosia = cells.ambrosia[i];
    organism.outcome.peak_cells = 1;
  }
  reorganise();
  state_.contacts.reset(cells.size());
}

template <class Part>
void Simulation::timed(StepPhase phase, Part&& part) {
  const Stopwatch watch(profile_, [phase](Profile& profile, Profile::Duration time) {
    profile.add_phase(phase, time);
  });
  part();
}

bool Simulation::step() {
  if (state_.finished) return false;
  timed(StepPhase::fields, [this] { update_fields(); });
  timed(StepPhase::sense, [this] { sense(); });
  timed(StepPhase::control, [this] { control(); });
  timed(StepPhase::decide, [this] { cycle_.decide(ecosystem_, state_, outputs_); });
  timed(StepPhase::metabolism, [this] { metabolism_.run(ecosystem_, state_, outputs_); });
  // Newborn cells stand at the end until the storage is reorganised; they do not deposit yet.
  const std::uint32_t count = state_.cells.size();
  bool changed = false;
  timed(StepPhase::cycle, [&] { changed = cycle_.advance(ecosystem_, state_); });
  timed(StepPhase::deposit, [&] { deposit(count); });
  if (changed) timed(StepPhase::cycle, [this] { reorganise(); });
  timed(StepPhase::mechanics, [this] { move(); });
  timed(StepPhase::stress, [this] { view_.act(Phase::stress); });
  bool buried = false;
  timed(StepPhase::deaths, [&] { buried = bury(); });
  timed(StepPhase::mechanics, [&] {
    mechanics_.list_contacts(state_.contacts,
                             buried ? reorganiser_.new_index() : std::span<const std::uint32_t>{});
  });
  timed(StepPhase::observe, [this] { end_step(); });
  return !state_.finished;
}

bool Simulation::run(const std::function<bool()>& stop) {
  while (!state_.finished) {
    if (stop && stop()) return false;
    step();
  }
  return true;
}

void Simulation::tell(Witness* witness) {
  witness_ = witness;
  cycle_.tell(witness);
  metabolism_.tell(witness);
}

void Simulation::measure(Profile* profile) {
  profile_ = profile;
  view_.measure(profile);
}

void Simulation::use(Team* team) {
  team_ = team;
  cycle_.use(team);
  metabolism_.use(team);
  mechanics_.use(team);
  reorganiser_.use(team);
  view_.use(team);
}

void Simulation::update_fields() {
  view_.act(Phase::parameters);
  view_.act(Phase::fields);
  const MorphogenGrid& grid = ecosystem_.config().morphogens;
  sweeps_.clear();
  std::uint32_t rows = 0;
  for (OrganismState& organism : state_.organisms) {
    if (organism.live == 0) continue;
    for (std::size_t kind = 0; kind < organism.fields.kinds(); ++kind) {
      const std::uint32_t own = organism.fields.begin_sweep(kind);
      sweeps_.push_back({&organism.fields, kind, own, rows});
      rows += own;
    }
  }
  // Some tens of squares take as long as a cell does.
  const std::uint64_t squares = std::uint64_t{rows} * grid.size;
  share(team_, rows, squares / 64, [&](std::uint32_t begin, std::uint32_t end) {
    for (const Sweep& sweep : sweeps_) {
      const std::uint32_t first = std::max(begin, sweep.before);
      const std::uint32_t last = std::min(end, sweep.before + sweep.rows);
      if (first < last)
        sweep.fields->sweep(sweep.kind, grid.kinds[sweep.kind], first - sweep.before, last - first);
    }
  });
  for (const Sweep& sweep : sweeps_)
    if (sweep.rows > 0) sweep.fields->end_sweep(sweep.kind);
}

void Simulation::sense() {
  const CellStore& cells = state_.cells;
  const std::size_t kinds = ecosystem_.config().morphogens.kinds.size();
  const std::size_t sensors = ecosystem_.schema().sensors.size();
  inputs_.reshape(static_cast<std::uint32_t>(kinds + 3 + sensors), cells.size());
  footprints_.resize(cells.size());
  const auto survey = [&](const CellRange& range) {
    const MorphogenFields& fields = state_.organisms[range.organism].fields;
    fields.survey(
        std::span(cells.x).subspan(range.begin, range.count()),
        std::span(cells.y).subspan(range.begin, range.count()),
        std::span(footprints_).subspan(range.begin, range.count()),
        inputs_.lanes(range.begin, range.count(), static_cast<std::uint32_t>(fields.kinds())));
  };
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    // The ranges of an organism stand together: its fields are surveyed once for all of them.
    CellRange body{.begin = begin, .end = begin};
    each_range(cells, begin, end, [&](const CellRange& range) {
      if (range.organism != body.organism) {
        if (body.count() > 0) survey(body);
        body = range;
      }
      body.end = range.end;
      sense(range);
    });
    if (body.count() > 0) survey(body);
  });
  view_.act(Phase::sense);
}

void Simulation::sense(const CellRange& range) {
  const CellStore& cells = state_.cells;
  const OrganismState& organism = state_.organisms[range.organism];
  const InputChannels& in = organism.phenotype->ports->in();
  const double capacity = state_.state_of(range.begin).skill(skill_capacity);
  const auto kinds = static_cast<std::uint32_t>(organism.fields.kinds());
  float* pressure = inputs_.row(in.pressure);
  float* energy = inputs_.row(in.energy);
  float* ambrosia = inputs_.row(in.ambrosia);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    pressure[i] = static_cast<float>(cells.pressure[i]);
    energy[i] = static_cast<float>(cells.energy[i]);
    ambrosia[i] = capacity > 0 ? static_cast<float>(cells.ambrosia[i] / capacity) : 0.0f;
  }
  for (std::uint32_t sensor = kinds + 3; sensor < inputs_.channels(); ++sensor)
    std::fill_n(inputs_.row(sensor) + range.begin, range.count(), 0.0f);
}

void Simulation::control() {
  std::uint32_t rows = 0;
  for (const OrganismState& organism : state_.organisms)
    rows = std::max(rows,
                    static_cast<std::uint32_t>(organism.phenotype->ports->layout().outputs.size()));
  outputs_.reshape(rows, state_.cells.size());
  // What a controller leaves unwritten is NaN: it counts as nothing and never wins.
  share_ranges(team_, state_.cells, [&](const CellRange& range) {
    for (std::uint32_t row = 0; row < rows; ++row)
      std::fill_n(outputs_.row(row) + range.begin, range.count(),
                  std::numeric_limits<float>::quiet_NaN());
  });
  run_programs();
  if (witness_ != nullptr) witness_->controlled(state_, inputs_, outputs_);
}

void Simulation::run_programs() {
  const CellStore& cells = state_.cells;
  const PluginCall here("controller", "step", state_.step);
  const Stopwatch watch(profile_, [&](Profile& profile, Profile::Duration time) {
    profile.add_call("controller", "step", time, cells.ranges.size());
  });
  try {
    share_ranges(team_, cells, [this](const CellRange& range) { run_program(range); });
  } catch (const std::bad_alloc&) {
    throw;  // the machine's fault, not the plugin's
  } catch (const std::exception& error) {
    throw PluginFailure("controller", "step at step " + std::to_string(state_.step), error.what());
  } catch (...) {
    throw PluginFailure("controller", "step at step " + std::to_string(state_.step),
                        "an exception that is no std::exception");
  }
}

void Simulation::run_program(const CellRange& range) {
  const Phenotype& phenotype = *state_.organisms[range.organism].phenotype;
  const Program& program = *phenotype.program;
  const Layout& layout = phenotype.ports->layout();
  const Batch batch{
      .count = range.count(),
      .organism = range.organism,
      .state = range.state,
      .in = std::as_const(inputs_).lanes(range.begin, range.count(), layout.input_channels),
      .memory = state_.cells.memory.lanes(range.begin, range.count(), program.memory_per_cell()),
      .out = outputs_.lanes(range.begin, range.count(),
                            static_cast<std::uint32_t>(layout.outputs.size()))};
  // Founders settle on their first inputs before their first step.
  if (state_.step == 0) {
    program.start(batch);
    for (std::uint32_t w = 0; w < ecosystem_.config().warm_up_steps; ++w) program.step(batch);
  }
  program.step(batch);
}

void Simulation::deposit(std::uint32_t count) {
  // Mothers have just moved; everybody else stands where it sensed.
  const CellStore& cells = state_.cells;
  for (const std::uint32_t mother : cycle_.mothers())
    footprints_[mother] =
        state_.organisms[cells.organism[mother]].fields.footprint(cells.x[mother], cells.y[mother]);
  // No two threads at a square: each has kinds of its own.
  const auto kinds = static_cast<unsigned>(ecosystem_.config().morphogens.kinds.size());
  const unsigned parts = team_ == nullptr ? 1 : std::min(team_->parts(count), kinds);
  const auto deposit_some = [&](unsigned part) {
    each_range(cells, 0, count, [&](const CellRange& range) {
      deposit(range, Kinds{part, parts});
    });
  };
  if (parts <= 1) return deposit_some(0);
  team_->run(parts, deposit_some);
}

void Simulation::deposit(const CellRange& range, Kinds kinds) {
  constexpr std::uint32_t most = 256;
  const CellStore& cells = state_.cells;
  OrganismState& organism = state_.organisms[range.organism];
  const std::vector<std::uint32_t>& channels = organism.phenotype->ports->out().morphogens;
  float amounts[most];
  for (std::uint32_t begin = range.begin; begin < range.end; begin += most) {
    const std::uint32_t count = std::min(most, range.end - begin);
    for (std::size_t kind = kinds.first; kind < channels.size(); kind += kinds.every) {
      const float* produced = outputs_.row(channels[kind]);
      for (std::uint32_t l = 0; l < count; ++l)
        amounts[l] =
            cells.dead[begin + l] != 0 ? 0.0f : static_cast<float>(share(produced[begin + l]));
      organism.fields.deposit(kind, std::span(footprints_).subspan(begin, count), {amounts, count},
                              ecosystem_.config().morphogens.deposit);
    }
  }
}

void Simulation::reorganise() { reorganiser_.run(state_.cells, {}); }

void Simulation::restructured() {
  state_.cells.ranges.clear();  // nothing is known to be in order
  reorganise();
  state_.contacts.reset(state_.cells.size());
  for (OrganismState& organism : state_.organisms) organism.live = 0;
  for (const std::uint16_t k : state_.cells.organism) ++state_.organisms[k].live;
}

void Simulation::move() {
  ExternalForces external;
  if (!ecosystem_.acting(Phase::forces).empty())
    external = [this](std::span<double> fx, std::span<double> fy) {
      view_.set_forces(fx, fy);
      view_.act(Phase::forces);
    };
  mechanics_.run(ecosystem_.config().mechanics, state_, external);
}

bool Simulation::bury() {
  CellStore& cells = state_.cells;
  const double limit = ecosystem_.config().radius * ecosystem_.config().radius;
  dead_.resize(cells.size());
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const bool inside = cells.x[i] * cells.x[i] + cells.y[i] * cells.y[i] <= limit;
      if (!inside) cells.kill(i, cause_outside);
      dead_[cells.rank[i]] = cells.dead[i];
    }
  });
  bool any = false;
  each_marked(dead_, 1, [&](std::uint32_t place) {
    const std::uint32_t i = cells.order[place];
    any = true;
    ++state_.organisms[cells.organism[i]].deaths[cells.cause[i]];
    lose(i, cells.cause[i] == cause_outside ? &Ledger::lost_outside : &Ledger::lost_death);
  });
  if (any) reorganiser_.run(cells, cells.dead);
  return any;
}

void Simulation::lose(std::uint32_t cell, Sum Ledger::*lost) {
  const CellStore& cells = state_.cells;
  if (witness_ != nullptr) witness_->died(state_, cell);
  OrganismState& organism = state_.organisms[cells.organism[cell]];
  organism.ledger.*lost += cells.ambrosia[cell];
  organism.ledger.energy_lost += cells.energy[cell];
  if (--organism.live > 0) return;
  organism.outcome.survival = state_.step;
  organism.fields = MorphogenFields(ecosystem_.config().morphogens);
}

std::uint32_t Simulation::wound(const Wound& wound) {
  const CellStore& cells = state_.cells;
  std::vector<std::uint8_t> marked(cells.size(), 0);
  std::uint32_t removed = 0;
  for (const std::uint32_t i : cells.order) {
    const double dx = cells.x[i] - wound.x, dy = cells.y[i] - wound.y;
    if (!(dx * dx + dy * dy <= wound.radius * wound.radius)) continue;
    marked[i] = 1;
    ++removed;
    lose(i, &Ledger::lost_death);
  }
  if (removed == 0) return 0;
  reorganiser_.run(state_.cells, marked);
  state_.contacts.remap(reorganiser_.new_index());
  const bool over = cells.size() == 0 && !state_.finished;
  if (over) finish();
  return removed;
}

void Simulation::end_step() {
  std::uint32_t living = 0;
  for (OrganismState& organism : state_.organisms) {
    living += organism.live;
    organism.outcome.cell_steps += organism.live;
    organism.outcome.peak_cells = std::max(organism.outcome.peak_cells, organism.live);
  }
  if (living > 0) {
    ++state_.inhabited_steps;
    for (OrganismState& organism : state_.organisms)
      organism.shares += static_cast<double>(organism.live) / living;
  }
  const bool stopped = view_.observe();
  ++state_.step;
  if (living == 0 || stopped || state_.step >= ecosystem_.config().max_steps) finish();
}

void Simulation::finish() {
  state_.finished = true;
  for (OrganismState& organism : state_.organisms) {
    organism.outcome.final_cells = organism.live;
    if (state_.inhabited_steps > 0)
      organism.outcome.biomass_share =
          organism.shares / static_cast<double>(state_.inhabited_steps);
    if (organism.live == 0) continue;
    organism.outcome.censored = true;
    organism.outcome.survival = state_.step;
  }
}

std::vector<Outcome> Simulation::outcomes() const {
  std::vector<Outcome> outcomes(state_.organisms.size());
  for (const OrganismState& organism : state_.organisms)
    outcomes[organism.roster_index] = organism.outcome;
  return outcomes;
}

std::vector<std::uint32_t> Simulation::census(std::size_t roster_index) const {
  std::vector<std::uint32_t> counts;
  for (std::size_t k = 0; k < state_.organisms.size(); ++k) {
    if (state_.organisms[k].roster_index != roster_index) continue;
    counts.assign(state_.organisms[k].phenotype->tree->states.size(), 0);
    for (const CellRange& range : state_.cells.ranges)
      if (range.organism == k) counts[range.state] += range.count();
  }
  return counts;
}

}  // namespace somas::model
