#include "core/experiment/keys.hpp"

#include <deque>
#include <limits>

#include "core/plugins/describe.hpp"

namespace somas::experiment {
namespace {

// ---- describing the core's structs -------------------------------------------------------------
// The structs stay plain; each has a describe function here, wrapped into what the SDK visits.

// Unsigned members cross as 64-bit integers.
template <class T>
void whole(Describe& d, const char* name, T& member, const char* doc, const Limits& limits) {
  auto value = static_cast<std::int64_t>(member);
  d(name, value, doc, limits);
  member = static_cast<T>(value);
}

constexpr double most_steps = 1e9;

void describe(Describe& d, model::MorphogenGrid& m);
void describe(Describe& d, model::Strangers& s);
void describe(Describe& d, model::Config& c);
void describe(Describe& d, evolution::Roster& r);
void describe(Describe& d, evolution::Settings& s);
void describe(Describe& d, RecordSettings& r);

void describe(Describe& d, model::Morphogen& m) {
  d("attenuation", m.attenuation, "Share of the concentration lost per side of a square",
    {.unit = "1/side", .minimum = 0, .maximum = 1});
  d("evaporation", m.evaporation, "Share of the concentration lost per step",
    {.unit = "1/step", .minimum = 0, .maximum = 1});
}

void describe(Describe& d, model::Mechanics& m) {
  whole(d, "substeps", m.substeps, "Substeps of the mechanics in a step",
        {.minimum = 1, .maximum = 1000});
  d("time_step", m.time_step, "Length of a substep; at most what a packed cluster bears",
    {.unit = "time", .minimum = 1e-9, .maximum = 1e3});
  d("damping", m.damping, "Normal damper of a pair of cells while a spring acts",
    {.unit = "force time/length", .minimum = 0, .maximum = 1e6});
  d("drag", m.drag, "Drag of a cell against the medium",
    {.unit = "force time/length", .minimum = 0, .maximum = 1e6});
  d("pressure_scale", m.pressure_scale,
    "Summed force of collision springs that reads as pressure 1/2",
    {.unit = "force", .minimum = 1e-9, .maximum = 1e9});
}

void describe(Describe& d, model::Metabolism& m) {
  const Limits cost = {.unit = "energy/step", .minimum = 0, .maximum = 1e6};
  d("quiescence_cost", m.quiescence_cost, "Energy a quiescent cell burns", cost);
  d("division_cost", m.division_cost, "Energy a dividing cell burns", cost);
  d("apoptosis_cost", m.apoptosis_cost, "Energy a cell in apoptosis burns", cost);
  d("specialization_cost", m.specialization_cost, "Energy a specializing cell burns", cost);
  d("motility_cost", m.motility_cost,
    "Energy a cell of a motile state burns beside, per unit of its `motility`",
    {.unit = "energy/(step force)", .minimum = 0, .maximum = 1e6});
  d("founder_energy", m.founder_energy, "Energy of the founder",
    {.unit = "energy", .minimum = 0, .maximum = 1, .minimum_open = true});
  d("founder_ambrosia", m.founder_ambrosia, "Ambrosia of the founder, at most its capacity",
    {.unit = "ambrosia", .minimum = 0, .maximum = 1e9});
}

void describe(Describe& d, model::Strangers& s) {
  d("adhere", s.adhere, "Whether they also stick to each other, as cells of one organism do");
  d("feed", s.feed,
    "Whether ambrosia passes between those that touch: by adhesion, or else by collision");
}

void describe(Describe& d, model::Cycle& c) {
  const Limits duration = {.unit = "steps", .minimum = 1, .maximum = most_steps};
  whole(d, "quiescence_steps", c.quiescence_steps, "Duration of quiescence", duration);
  whole(d, "division_steps", c.division_steps, "Duration of division", duration);
  whole(d, "apoptosis_steps", c.apoptosis_steps, "Duration of apoptosis", duration);
  whole(d, "specialization_steps", c.specialization_steps, "Duration of specialization", duration);
  d("division_energy", c.division_energy, "Least energy to begin a division",
    {.unit = "energy", .minimum = 0, .maximum = 1});
  d("division_pressure", c.division_pressure, "Greatest pressure to begin a division",
    {.minimum = 0, .maximum = 1});
}

template <class T>
struct Block {
  T& values;
  void describe(Describe& d) { experiment::describe(d, values); }
};

template <class T>
void block(Describe& d, const char* name, T& values, const char* doc) {
  Block<T> described{values};
  d.group(name, described, doc);
}

struct MorphogenElement {
  model::Morphogen values;
  void describe(Describe& d) { experiment::describe(d, values); }
};

void describe(Describe& d, model::MorphogenGrid& m) {
  whole(d, "size", m.size, "Squares along an edge of the grid; odd, so that one is at the centre",
        {.unit = "squares", .minimum = 1, .maximum = 16383});
  d("side", m.side, "Edge of a square", {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
  std::string deposit = m.deposit == model::Deposit::peak ? "peak" : "share";
  d.choice("deposit", deposit, {"peak", "share"},
           "Whether the square nearest to a cell gets its whole production, or its share of it");
  m.deposit = deposit == "peak" ? model::Deposit::peak : model::Deposit::share;

  std::vector<MorphogenElement> kinds;
  for (const model::Morphogen& kind : m.kinds) kinds.push_back({kind});
  d.list("kinds", kinds, "The morphogens, in order");
  m.kinds.clear();
  for (const MorphogenElement& kind : kinds) m.kinds.push_back(kind.values);
}

void describe(Describe& d, model::Config& c) {
  d("radius", c.radius, "Radius of the world; cells beyond it are removed",
    {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
  whole(d, "max_steps", c.max_steps, "Steps after which a simulation ends, marked censored",
        {.unit = "steps", .minimum = 1, .maximum = most_steps});
  whole(d, "max_cells", c.max_cells, "Most cells of an organism, living and being born",
        {.unit = "cells", .minimum = 1, .maximum = 1e7});
  whole(d, "warm_up_steps", c.warm_up_steps, "Controller steps of a founder before step 0",
        {.unit = "steps", .minimum = 0, .maximum = 1e6});
  block(d, "morphogens", c.morphogens, "Signals between cells");
  block(d, "mechanics", c.mechanics, "Springs, dampers and time steps");
  block(d, "metabolism", c.metabolism, "Energy");
  block(d, "strangers", c.strangers, "Cells of different organisms; they always collide");
  block(d, "cycle", c.cycle, "Durations and conditions of the cells' actions");
}

void describe(Describe& d, evolution::Roster& r) {
  whole(d, "size", r.size, "Organisms of a simulation, in all modes but solo",
        {.unit = "organisms", .minimum = 2, .maximum = 1000});
  d("distance", r.distance, "Distance of the founders from the centre, in all modes but solo",
    {.unit = "length", .minimum = 1e-3, .maximum = 1e6});
  std::string hall(name_of(r.hall));
  d.choice("hall", hall, {"even", "random"},
           "How hall_of_fame draws among earlier champions: evenly, the newest among them, or at "
           "random");
  r.hall = hall == "even" ? evolution::Hall::even : evolution::Hall::random;
}

void describe(Describe& d, evolution::Settings& s) {
  std::string mode(name_of(s.mode));
  d.choice("mode", mode, {"solo", "rosters", "coevolution", "hall_of_fame"},
           "Whom an individual meets: nobody, others of its population, members of its own and of "
           "a second population, champions of earlier generations");
  s.mode = *evolution::mode_named(mode);
  whole(d, "population", s.population, "Individuals of a generation",
        {.unit = "individuals", .minimum = 1, .maximum = 1e7});
  whole(d, "generations", s.generations, "Generations of a run",
        {.unit = "generations", .minimum = 1, .maximum = 1e9});
  whole(d, "tournament", s.tournament, "Individuals that compete to be a parent",
        {.unit = "individuals", .minimum = 1, .maximum = 1e6});
  d("elite_fraction", s.elite_fraction,
    "Share of the best that go on unchanged, at least one individual",
    {.minimum = 0, .maximum = 1});
  d("crossover", s.crossover, "Probability that a child has two parents",
    {.minimum = 0, .maximum = 1});
  d("mutation", s.mutation, "Probability that a child is mutated", {.minimum = 0, .maximum = 1});
  whole(d, "trials", s.trials, "Simulations that an individual's fitness is averaged over",
        {.unit = "simulations", .minimum = 1, .maximum = 1e6});
  block(d, "roster", s.roster, "Several organisms in one world, in all modes but solo");
}

void describe(Describe& d, RecordSettings& r) {
  std::string what = r.what == Recorded::champions ? "champions"
                     : r.what == Recorded::all     ? "all"
                                                   : "none";
  d.choice("what", what, {"none", "champions", "all"},
           "Whose lives are recorded: nobody's, every generation's best, everybody's (their first "
           "trials are simulated again, one by one)");
  r.what = what == "champions" ? Recorded::champions
           : what == "all"     ? Recorded::all
                               : Recorded::none;
  whole(d, "every", r.every, "Steps between frames; the last step always has one",
        {.unit = "steps", .minimum = 1, .maximum = most_steps});
  whole(d, "fields_every", r.fields_every,
        "Frames with grids and morphogens are those of steps divisible by it; 0: all frames",
        {.unit = "steps", .minimum = 0, .maximum = most_steps});
  d("controller", r.controller, "Whether frames hold the inputs and outputs of the controllers");
}

void describe(Describe& d, CoreValues& v) {
  d("somas", v.format, "Version of the file format",
    {.minimum = static_cast<double>(format_version),
     .maximum = static_cast<double>(format_version)});
  d("name", v.name, "Name of the experiment; left out: the file's, without its extension");
  d("seed", v.seed, "Seed of everything random", {.minimum = 0});
  d("replicates", v.replicates,
    "Runs of each condition, with the seeds `seed`, `seed` + 1, ...; more than one make a campaign",
    {.unit = "runs", .minimum = 1, .maximum = 10'000});
  block(d, "world", v.world, "The organisms' world");
  block(d, "evolution", v.evolution, "The genetic algorithm");
  block(d, "record", v.record, "Recordings of lives, in the run's directory");
}

// ---- the list of keys --------------------------------------------------------------------------

constexpr OtherKey other[] = {
    {"extends", "text", "none",
     "File to start from, relative to this one: mappings merge, everything else replaces; a block "
     "that names another `plugin` replaces the inherited block"},
    {"sweep", "mapping", "`{}`",
     "Factors of a campaign: a key of this file with a list of its values, or a name with levels, "
     "each of which is a name with the keys that it sets; see campaigns.md"},
    {"plugins", "list of texts", "none",
     "Directories to search for plugins first, relative to this file"},
    {"environments", "mapping", "`{}`",
     "Environments by name, in the order in which they act: each has `plugin` (default: its name) "
     "and that plugin's parameters; null removes an inherited one"},
    {"specialization", "mapping", "required",
     "`plugin` and the parameters of a specialization tree"},
    {"controller", "mapping", "required", "`plugin` and the parameters of a controller"},
    {"fitness", "mapping", "required", "`plugin` and the parameters of a fitness definition"},
};

}  // namespace

std::span<const ParameterInfo> core_keys() {
  static const Describe described = [] {
    Describe d;
    CoreValues values;
    describe(d, values);
    return d;
  }();
  return described.parameters();
}

CoreValues core_values(const plugins::ParameterValue& group) {
  const plugins::PackedValue packed(group);
  CoreValues values;
  Describe reader(packed.value());
  describe(reader, values);
  return values;
}

std::span<const OtherKey> other_keys_described() { return other; }

const std::vector<std::string>& other_keys() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const OtherKey& key : other) all.emplace_back(key.name);
    return all;
  }();
  return names;
}

std::string keys_reference() {
  std::string out = plugins::markdown_header;
  for (const OtherKey& key : other)
    out += std::string("| `") + key.name + "` | " + key.type + " | " + key.fallback + " |  | " +
           key.doc + " |\n";
  return out + plugins::markdown_rows(core_keys());
}

}  // namespace somas::experiment
