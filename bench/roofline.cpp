#include "bench/roofline.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/ceilings.hpp"
#include "bench/colonies.hpp"
#include "bench/step_costs.hpp"
#include "bench/subject.hpp"
#include "core/evaluation/simulate.hpp"
#include "core/model/mechanics.hpp"
#include "core/model/neighbours.hpp"
#include "core/run/files.hpp"
#include "core/run/life_record.hpp"

namespace somas::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double nanoseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
}

double nanoseconds(model::Profile::Duration time) {
  return std::chrono::duration<double, std::nano>(time).count();
}

// ---- counting ----------------------------------------------------------------------------------

/// The reach that mechanics finds pairs with: see core/model/mechanics.cpp.
constexpr double skin = 0.15;
double looking_ahead(const model::Mechanics& constants) {
  return 2.0 * constants.substeps * constants.time_step;
}

/// Pairs that a search has to look at: those in the same bin and in half of the bins round it.
double candidates(const std::vector<model::Body>& bodies, double range, double time) {
  constexpr double widest_margin = 0.2;
  double radius = 0, margin = 0, left = bodies.front().x, bottom = bodies.front().y, right = left;
  for (const model::Body& body : bodies) {
    radius = std::max(radius, body.radius);
    margin =
        std::max(margin, 0.5 * skin + std::min(widest_margin, time * std::hypot(body.vx, body.vy)));
    left = std::min(left, body.x), right = std::max(right, body.x),
    bottom = std::min(bottom, body.y);
  }
  const double side = 2 * (radius * range + margin);
  const auto columns = static_cast<std::size_t>((right - left) / side) + 3;
  std::vector<double> bins;
  for (const model::Body& body : bodies) {
    const std::size_t bin = static_cast<std::size_t>((body.y - bottom) / side) * columns +
                            static_cast<std::size_t>((body.x - left) / side) + 1;
    bins.resize(std::max(bins.size(), bin + columns + 2));
    ++bins[bin];
  }
  double pairs = 0;
  for (std::size_t b = 0; b + columns + 1 < bins.size(); ++b) {
    const std::size_t below = std::max(b, std::size_t{1}) - 1 + columns;
    pairs += bins[b] *
             (0.5 * (bins[b] - 1) + bins[b + 1] + bins[below] + bins[below + 1] + bins[below + 2]);
  }
  return pairs;
}

/// Times of mechanics while the lists of pairs stand, for all cells of the worlds seen.
struct Standing {
  double substeps = 0, rest = 0, cells = 0;
};

/// Looks at a life after every step.
class Counter {
 public:
  explicit Counter(const model::Ecosystem& ecosystem) : ecosystem_(ecosystem) {}

  void see(const model::Simulation& life, bool closely) {
    const model::WorldState& world = life.state();
    if (world.cells.size() == 0) return;
    const model::OrganismState& organism = world.organisms.front();
    ++steps_;
    const double cells = world.cells.size();
    cell_steps_ += cells;
    sum_.patches += static_cast<double>(world.grids.front().size());
    sum_.particles += world.tables.front().rows();
    sum_.touching += 0.5 * static_cast<double>(world.contacts.items.size());
    for (std::size_t kind = 0; kind < organism.fields.kinds(); ++kind) {
      const auto& box = organism.fields.box(kind);
      if (box.left > box.right) continue;
      sum_.squares += double{box.right - box.left + 1.0} * double{box.top - box.bottom + 1.0};
    }
    for (const model::Action action : world.cells.action) {
      sum_.deciding += action == model::Action::none ? 1 : 0;
      sum_.dividing += action == model::Action::division ? 1 : 0;
    }
    count_storage(organism);
    if (closely) see_pairs(world);
    if (closely) time_mechanics(world);
  }

  [[nodiscard]] Items items(const model::Phenotype& phenotype,
                            const model::WorldState& world) const {
    Items items = sum_;
    for (double* of_a_cell : {&items.patches, &items.particles, &items.touching, &items.squares,
                              &items.deciding, &items.dividing})
      *of_a_cell /= cell_steps_;
    items.births_storage /= steps_;
    items.deaths_storage /= steps_;
    items.candidates /= seen_cells_;
    items.pairs /= seen_cells_;
    items.builds = builds_ / seen_;
    items.kinds = static_cast<double>(ecosystem_.config().morphogens.kinds.size());
    items.substeps = ecosystem_.config().mechanics.substeps;
    const Layout& layout = phenotype.ports->layout();
    items.inputs = layout.input_channels;
    items.outputs = static_cast<double>(layout.outputs.size());
    items.targets = phenotype.program->memory_per_cell();
    items.column_bytes = 4 * items.targets;
    world.cells.each_column(
        [&](const auto& column) { items.column_bytes += sizeof(column.front()); });
    return items;
  }
  [[nodiscard]] const Standing& standing() const { return standing_; }

 private:
  void count_storage(const model::OrganismState& organism) {
    const std::uint64_t changed = organism.outcome.divisions + organism.outcome.specializations;
    std::uint64_t died = 0;
    for (const std::uint64_t deaths : organism.deaths) died += deaths;
    sum_.births_storage += changed > changed_ ? 1 : 0;
    sum_.deaths_storage += died > died_ ? 1 : 0;
    changed_ = changed;
    died_ = died;
  }

  void see_pairs(const model::WorldState& world) {
    const std::vector<model::Body> bodies = bodies_of(world.cells);
    const model::Mechanics& constants = ecosystem_.config().mechanics;
    double range = 1;
    for (const model::CellRange& cells : world.cells.ranges)
      range = std::max(range, world.state_of(cells.begin).adhesion_range);
    ++seen_;
    if (pairs_.stale(bodies, range)) {
      pairs_.build(bodies, range, skin, looking_ahead(constants));
      ++builds_;
    }
    seen_cells_ += static_cast<double>(bodies.size());
    sum_.pairs += static_cast<double>(pairs_.first().size());
    sum_.candidates += candidates(bodies, range, looking_ahead(constants));
  }

  /// One substep more or less tells what substeps take; the rest is what comes before and after.
  void time_mechanics(const model::WorldState& here) {
    world_ = here;
    const model::Mechanics& all = ecosystem_.config().mechanics;
    model::Mechanics one = all;
    one.substeps = 1;
    solver_.run(all, world_, {});
    solver_.list_contacts(world_.contacts);
    double least_all = 1e300, least_one = 1e300;
    for (int turn = 0; turn < 7; ++turn) {
      least_all = std::min(least_all, time_of(all, here));
      least_one = std::min(least_one, time_of(one, here));
    }
    const double substep = std::max(0.0, least_all - least_one) / (all.substeps - 1.0);
    standing_.substeps += all.substeps * substep;
    standing_.rest += least_all - all.substeps * substep;
    standing_.cells += here.cells.size();
  }

  double time_of(const model::Mechanics& constants, const model::WorldState& here) {
    world_.cells.x = here.cells.x, world_.cells.y = here.cells.y;
    world_.cells.vx = here.cells.vx, world_.cells.vy = here.cells.vy;
    const Clock::time_point begin = Clock::now();
    solver_.run(constants, world_, {});
    solver_.list_contacts(world_.contacts);
    return nanoseconds_since(begin);
  }

  const model::Ecosystem& ecosystem_;
  Items sum_;
  double steps_ = 0, cell_steps_ = 0, seen_ = 0, seen_cells_ = 0, builds_ = 0;
  std::uint64_t changed_ = 0, died_ = 0;
  model::NeighbourPairs pairs_;
  model::MechanicsSolver solver_;
  model::WorldState world_;
  Standing standing_;
};

// ---- measuring ---------------------------------------------------------------------------------

/// A world's items and times, in nanoseconds a cell-step.
struct Measured {
  std::string title;
  std::string level;     ///< of the caches, that the world streams from
  double bandwidth = 0;  ///< of it, bytes a second
  Items items;
  std::array<double, parts> time{};
  double whole = 0;
};

/// Nanoseconds of some steps, each by itself, by phase and of two calls within them. Of each the
/// least that several runs of the same steps took: what others did to the machine meanwhile is in
/// few.
class Times {
 public:
  /// Another run begins.
  void restart() {
    step_ = 0;
    before_ = {};
  }
  /// A step is over; `profile` has what the run took so far.
  void see(const model::Profile& profile) {
    Row now{};
    for (std::size_t p = 0; p < model::step_phases; ++p)
      now[p] = nanoseconds(profile.phase(static_cast<model::StepPhase>(p)));
    for (const model::Profile::Call& call : profile.calls()) {
      if (call.plugin != "nutrients") continue;
      if (call.call == "act(fields)") now[growing] = nanoseconds(call.time);
      if (call.call == "act(sense)") now[tasting] = nanoseconds(call.time);
    }
    if (step_ == least_.size()) least_.emplace_back().fill(1e300);
    for (std::size_t k = 0; k < now.size(); ++k)
      least_[step_][k] = std::min(least_[step_][k], now[k] - before_[k]);
    before_ = now;
    ++step_;
  }
  [[nodiscard]] double of(model::StepPhase phase) const {
    return sum(static_cast<std::size_t>(phase));
  }
  [[nodiscard]] double of_growing_nutrients() const { return sum(growing); }
  [[nodiscard]] double of_sensing_nutrients() const { return sum(tasting); }

 private:
  static constexpr std::size_t growing = model::step_phases, tasting = growing + 1;
  using Row = std::array<double, model::step_phases + 2>;

  [[nodiscard]] double sum(std::size_t column) const {
    double total = 0;
    for (const Row& row : least_) total += row[column];
    return total;
  }

  std::vector<Row> least_;
  Row before_{};
  std::size_t step_ = 0;
};

void divide_time(const Times& times, double cell_steps, const Standing& standing,
                 Measured& measured) {
  using model::StepPhase;
  const auto phase = [&](StepPhase p) { return times.of(p); };
  const double growing = times.of_growing_nutrients(), tasting = times.of_sensing_nutrients();
  const auto set = [&](Part part, double time) {
    measured.time[static_cast<std::size_t>(part)] = time / cell_steps;
  };
  set(Part::nutrients, growing + tasting);
  set(Part::sweep, phase(StepPhase::fields) - growing);
  set(Part::sense_deposit, phase(StepPhase::sense) - tasting + phase(StepPhase::deposit));
  set(Part::control, phase(StepPhase::control));
  set(Part::cycle, phase(StepPhase::decide) + phase(StepPhase::cycle));
  set(Part::metabolism, phase(StepPhase::metabolism));
  set(Part::particles, phase(StepPhase::stress));
  set(Part::deaths, phase(StepPhase::deaths));
  // Of mechanics: what it takes with standing lists is known; finding them is the rest.
  const double a_cell = cell_steps / standing.cells;
  set(Part::substeps, standing.substeps * a_cell);
  set(Part::contacts, standing.rest * a_cell);
  set(Part::find_pairs,
      std::max(0.0, phase(StepPhase::mechanics) - (standing.substeps + standing.rest) * a_cell));
  for (std::size_t p = 0; p < model::step_phases; ++p)
    measured.whole += phase(static_cast<StepPhase>(p)) / cell_steps;
}

Measured measure_life(const Ceilings& ceilings, double seconds) {
  const model::Ecosystem& ecosystem = *shipped().ecosystem;
  const evaluation::Task task = run::single_task(champion().individual.genome, champion().seed);
  const model::Phenotype phenotype = ecosystem.express(champion().individual.genome);

  Times times;
  double cell_steps = 0;
  const Clock::time_point begin = Clock::now();
  do {
    model::Profile profile;
    times.restart();
    static_cast<void>(evaluation::simulate(
        ecosystem, task, {}, [&](const model::Simulation&) { times.see(profile); }, nullptr,
        &profile));
    cell_steps = profile.cell_steps();
  } while (nanoseconds_since(begin) < 1e9 * seconds);

  Counter counter(ecosystem);
  std::optional<Items> items;
  static_cast<void>(evaluation::simulate(ecosystem, task, {}, [&](const model::Simulation& life) {
    counter.see(life, true);
    items = counter.items(phenotype, life.state());
  }));
  Measured measured{.title = "The champion's life, 133 cells on average",
                    .level = "L2",
                    .bandwidth = ceilings.l2,
                    .items = items.value()};
  divide_time(times, cell_steps, counter.standing(), measured);
  return measured;
}

Measured measure_colonies(const Ceilings& ceilings, std::uint32_t cells) {
  constexpr int steps = 3, stretches = 4;
  Colonies world(cells);
  model::Simulation& simulation = world.simulation();
  const auto cell_steps = [&] { return simulation.outcomes().front().cell_steps; };
  const double before = cell_steps();
  Times times;
  for (int stretch = 0; stretch < stretches; ++stretch) {
    world.rewind();
    model::Profile profile;
    simulation.measure(&profile);
    times.restart();
    for (int step = 0; step < steps; ++step) {
      simulation.step();
      times.see(profile);
    }
    simulation.measure(nullptr);
  }
  const double lived = cell_steps() - before;

  world.rewind();
  Counter counter(*world.experiment().ecosystem);
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    counter.see(simulation, step == steps - 1);
  }
  Measured measured{
      .title = "Colonies of " + std::to_string(cells) + " cells",
      .level = "DRAM",
      .bandwidth = ceilings.dram,
      .items = counter.items(*simulation.state().organisms.front().phenotype, simulation.state())};
  divide_time(times, lived, counter.standing(), measured);
  return measured;
}

// ---- reporting ---------------------------------------------------------------------------------

/// The least time of some work, in nanoseconds, when all that can overlap does.
struct Bound {
  double time = 0;
  std::string by;
};

Bound bound_of(const Work& work, const Ceilings& c, const Measured& measured) {
  const Bound arithmetic{1e9 * (work.flops64 / c.flops64 + work.flops32 / c.flops32), "arithmetic"};
  const Bound roots{1e9 * (work.divisions64 / c.divisions64 + work.divisions32 / c.divisions32 +
                           work.roots64 / c.roots64 + work.roots32 / c.roots32),
                    "roots, divisions"};
  const Bound memory{1e9 * work.bytes / measured.bandwidth, measured.level};
  return std::max({arithmetic, roots, memory},
                  [](const Bound& a, const Bound& b) { return a.time < b.time; });
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value >= 100 ? "%.0f" : value >= 10 ? "%.1f" : "%.2f", value);
  return text;
}

std::string row(const std::vector<std::string>& cells) {
  std::string text = "|";
  for (const std::string& cell : cells) text += " " + cell + " |";
  return text + "\n";
}

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

std::string table_of(const Ceilings& c) {
  const auto giga = [](double value) { return number(value / 1e9); };
  std::string text = row({"ceiling", "float64", "float32", ""});
  text += "|---|---|---|---|\n";
  text += row({"multiplications and additions", giga(c.flops64), giga(c.flops32),
               "thousand million a second"});
  text += row({"divisions", giga(c.divisions64), giga(c.divisions32), "thousand million a second"});
  text += row({"square roots", giga(c.roots64), giga(c.roots32), "thousand million a second"});
  text += "\n" + row({"triad in", "L1", "L2", "L3", "DRAM", ""}) + "|---|---|---|---|---|---|\n";
  text += row({"bandwidth", giga(c.l1), giga(c.l2), giga(c.l3), giga(c.dram), "GB/s"});
  return text;
}

std::string table_of(const Measured& measured, const Ceilings& ceilings) {
  std::string text = "**" + measured.title + ".** Bytes stream from " + measured.level + ".\n\n";
  text += row({"phase", "float64", "float32", "divisions, roots", "bytes", "bound by",
               "at least, ns", "measured, ns", "reached"});
  text += "|---|---|---|---|---|---|---|---|---|\n";
  Work all;
  double least = 0;
  const auto cells_of = [&](const std::string& name, const Work& work, const std::string& by,
                            double at_least, double time) {
    return row({name, number(work.flops64), number(work.flops32),
                number(work.divisions64 + work.divisions32 + work.roots64 + work.roots32),
                number(work.bytes), by, number(at_least), number(time),
                time > 0 ? number(100 * at_least / time) + " %" : "-"});
  };
  for (std::size_t p = 0; p < parts; ++p) {
    const Work work = work_of(static_cast<Part>(p), measured.items);
    const Bound bound = bound_of(work, ceilings, measured);
    all += work;
    least += bound.time;
    text += cells_of(name_of(static_cast<Part>(p)), work, bound.by, bound.time, measured.time[p]);
  }
  return text + cells_of("**the whole step**", all, "", least, measured.whole);
}

std::string items_of(const Items& n) {
  return "A cell-step has " + number(n.particles) + " particles, " + number(n.squares) +
         " morphogen squares, " + number(n.patches) + " nutrient patches, " + number(n.candidates) +
         " candidates and " + number(n.pairs) + " pairs of neighbours, " + number(n.touching) +
         " pairs in contact; a step finds pairs " + number(n.builds) + " times.\n";
}

std::string markdown(const Ceilings& ceilings, const std::vector<Measured>& worlds) {
  std::string text = "One core of: " + processor() + ".\n\n" + table_of(ceilings);
  for (const Measured& world : worlds)
    text += "\n" + table_of(world, ceilings) + "\n" + items_of(world.items);
  return text;
}

Json json_of(const Ceilings& c, const std::vector<Measured>& worlds) {
  Json json;
  json["processor"] = processor();
  json["ceilings"] = {{"flops64", c.flops64},
                      {"flops32", c.flops32},
                      {"divisions64", c.divisions64},
                      {"divisions32", c.divisions32},
                      {"roots64", c.roots64},
                      {"roots32", c.roots32},
                      {"l1", c.l1},
                      {"l2", c.l2},
                      {"l3", c.l3},
                      {"dram", c.dram}};
  for (const Measured& world : worlds) {
    Json of_world{{"title", world.title}, {"level", world.level}, {"seconds", 1e-9 * world.whole}};
    for (std::size_t p = 0; p < parts; ++p) {
      const Work work = work_of(static_cast<Part>(p), world.items);
      const Bound bound = bound_of(work, c, world);
      of_world["phases"].push_back({{"phase", name_of(static_cast<Part>(p))},
                                    {"flops64", work.flops64},
                                    {"flops32", work.flops32},
                                    {"divisions64", work.divisions64},
                                    {"divisions32", work.divisions32},
                                    {"roots64", work.roots64},
                                    {"roots32", work.roots32},
                                    {"bytes", work.bytes},
                                    {"bound_by", bound.by},
                                    {"least_seconds", 1e-9 * bound.time},
                                    {"seconds", 1e-9 * world.time[p]}});
    }
    json["worlds"].push_back(std::move(of_world));
  }
  return json;
}

/// Puts the text between the marks of the page.
void update_page(const std::string& text) {
  const std::filesystem::path page = SOMAS_SOURCE_DIR "/docs/roofline.md";
  const std::string whole = run::read_file(page), opening = "<!-- measured: roofline -->\n";
  const std::size_t mark = whole.find(opening), end = whole.find("<!-- end -->", mark);
  if (mark == std::string::npos || end == std::string::npos)
    throw std::runtime_error(page.string() + " has no part for the roofline");
  run::write_file(page,
                  whole.substr(0, mark + opening.size()) + "\n" + text + "\n" + whole.substr(end));
}

}  // namespace

int roofline(std::span<char* const> arguments) {
  bool as_json = false, update = false, quick = false;
  for (const std::string_view argument : arguments) {
    as_json |= argument == "--json";
    update |= argument == "--update";
    quick |= argument == "--quick";
    if (argument == "--json" || argument == "--update" || argument == "--quick") continue;
    std::fputs("usage: --roofline [--json | --update] [--quick]\n", stderr);
    return 2;
  }
  const Ceilings ceilings = measure_ceilings(quick ? 0.05 : 3);
  const std::vector<Measured> worlds{measure_life(ceilings, quick ? 0 : 8),
                                     measure_colonies(ceilings, quick ? 1'000 : 1'000'000)};
  if (update) {
    update_page(markdown(ceilings, worlds));
    return 0;
  }
  const std::string text =
      as_json ? json_of(ceilings, worlds).dump(2) + "\n" : markdown(ceilings, worlds);
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace somas::bench
