#include "core/model/snapshot.hpp"

#define XXH_INLINE_ALL
#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <xxhash.h>

namespace somas::model {
namespace {

constexpr std::string_view magic = "SOMASNAP";
constexpr std::size_t checksum_size = sizeof(std::uint64_t);

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

// ---- bytes -------------------------------------------------------------------------------------

class Writer {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
  }
  void put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }
  void raw(std::string_view text) {
    for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
  }
  template <class T>
  void put(std::span<const T> values) {
    for (const T value : values) put(value);
  }
  void put(const Sum& sum) {
    put(sum.sum());
    put(sum.error());
  }
  [[nodiscard]] std::vector<std::byte> finish() {
    put(checksum_of(bytes_));
    return std::move(bytes_);
  }

 private:
  std::vector<std::byte> bytes_;
};

[[noreturn]] void damaged(const std::string& what) {
  throw SnapshotError("the saved state is damaged: " + what);
}

void require(bool valid, const char* what) {
  if (!valid) damaged(what);
}

/// Never reads, nor makes room for, more than there is.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  void get(T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), take(sizeof(T)).data(), sizeof(T));
    if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
    if constexpr (std::is_same_v<T, bool>) {
      require(raw[0] <= std::byte{1}, "a truth value is neither 0 nor 1");
      value = raw[0] != std::byte{0};
    } else {
      value = std::bit_cast<T>(raw);
    }
  }
  template <class T>
  [[nodiscard]] T get() {
    T value;
    get(value);
    return value;
  }
  [[nodiscard]] std::string text() {
    const std::span<const std::byte> raw = take(get<std::uint32_t>());
    std::string text(raw.size(), '\0');
    std::transform(raw.begin(), raw.end(), text.begin(), [](std::byte b) { return char(b); });
    return text;
  }
  template <class T>
  void get(std::vector<T>& values, std::size_t count) {
    require(count <= rest_.size() / sizeof(T), "it ends too early");
    values.resize(count);
    for (T& value : values) get(value);
  }
  void get(Sum& sum) {
    const double plain = get<double>(), error = get<double>();
    sum = Sum(plain, error);
  }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::byte> take(std::size_t count) {
    require(count <= rest_.size(), "it ends too early");
    const std::span<const std::byte> taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }

  std::span<const std::byte> rest_;
};

// ---- vocabulary --------------------------------------------------------------------------------

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

template <class T, class Name>
std::string listed(const std::vector<T>& items, Name&& name) {
  std::string text;
  for (const T& item : items) text += (text.empty() ? "" : ", ") + name(item);
  return text;
}

std::string itself(const std::string& name) { return name; }

template <class T>
std::string owned_name(const T& declared) {
  return declared.owner + "." + declared.name;
}

std::string shape(const GridDeclaration& grid) {
  const GridSpec& spec = grid.spec;
  return owned_name(grid) + " " + std::to_string(spec.columns) + " x " + std::to_string(spec.rows) +
         " of side " + number(spec.side) + " from (" + number(spec.left) + ", " +
         number(spec.bottom) + ")";
}

std::string states_of(const Tree& tree) {
  return listed(tree.states, [](const State& state) { return state.name; });
}

/// Parameters that somebody varies: those are saved.
std::string varied(const Schema& schema) {
  std::string text;
  for (const VariableParameter& parameter : schema.parameters)
    if (!parameter.in_charge.empty()) text += (text.empty() ? "" : ", ") + owned_name(parameter);
  return text;
}

void compare(const std::string& what, const std::string& saved, const std::string& here) {
  if (saved == here) return;
  const auto shown = [](const std::string& value) { return value.empty() ? "none" : value; };
  throw SnapshotError("the saved state is of another experiment: " + what + ": " + shown(saved) +
                      " in the state, " + shown(here) + " in the experiment");
}

void put_vocabulary(Writer& out, const Ecosystem& ecosystem) {
  const auto words = vocabulary(ecosystem);
  out.put(static_cast<std::uint32_t>(words.size()));
  for (const auto& [what, value] : words) {
    out.put(std::string_view(what));
    out.put(std::string_view(value));
  }
}

void check_vocabulary(Reader& in, const Ecosystem& ecosystem) {
  const auto words = vocabulary(ecosystem);
  require(in.get<std::uint32_t>() == words.size(), "its vocabulary is another one");
  for (const auto& [what, here] : words) {
    require(in.text() == what, "its vocabulary is another one");
    compare(what, in.text(), here);
  }
}

// ---- organisms ---------------------------------------------------------------------------------

/// Calls visit(sum) for every sum of a ledger.
template <class L, class Visit>
void each_sum(L& ledger, Visit&& visit) {
  visit(ledger.taken), visit(ledger.burnt), visit(ledger.given), visit(ledger.received);
  visit(ledger.lost_efficiency);
  visit(ledger.lost_overflow), visit(ledger.lost_death), visit(ledger.lost_outside);
  visit(ledger.spent), visit(ledger.energy_lost);
}

/// Calls visit(number) for all that an outcome holds.
template <class O, class Visit>
void each_number(O& outcome, Visit&& visit) {
  visit(outcome.survival), visit(outcome.censored), visit(outcome.divisions);
  visit(outcome.specializations), visit(outcome.refused_divisions), visit(outcome.final_cells);
  visit(outcome.peak_cells), visit(outcome.cell_steps), visit(outcome.biomass_share);
}

void put_fields(Writer& out, const MorphogenFields& fields) {
  for (std::size_t kind = 0; kind < fields.kinds(); ++kind) {
    const MorphogenFields::Box& box = fields.box(kind);
    for (const std::uint32_t edge : {box.left, box.right, box.bottom, box.top}) out.put(edge);
    if (box.left > box.right) continue;
    for (std::uint32_t row = box.bottom; row <= box.top; ++row)
      for (std::uint32_t column = box.left; column <= box.right; ++column)
        out.put(fields.value(kind, column, row));
  }
}

void get_fields(Reader& in, MorphogenFields& fields) {
  for (std::size_t kind = 0; kind < fields.kinds(); ++kind) {
    MorphogenFields::Box box;
    for (std::uint32_t* edge : {&box.left, &box.right, &box.bottom, &box.top}) in.get(*edge);
    if (box == MorphogenFields::Box{}) continue;
    require(box.left <= box.right && box.right < fields.size() && box.bottom <= box.top &&
                box.top < fields.size(),
            "morphogens lie off their grid");
    // Setting all of its squares makes the box what it was.
    for (std::uint32_t row = box.bottom; row <= box.top; ++row)
      for (std::uint32_t column = box.left; column <= box.right; ++column)
        fields.set(kind, column, row, in.get<float>());
  }
}

void put_organism(Writer& out, const OrganismState& organism) {
  out.put(organism.key);
  out.put(organism.roster_index);
  out.put(std::string_view(states_of(*organism.phenotype->tree)));
  out.put(organism.phenotype->program->memory_per_cell());
  out.put(organism.next_id);
  out.put(organism.live);
  out.put(organism.shares);
  out.put(organism.ledger.founder_ambrosia);
  out.put(organism.ledger.founder_energy);
  each_sum(organism.ledger, [&](const Sum& sum) { out.put(sum); });
  each_number(organism.outcome, [&](auto value) { out.put(value); });
  out.put(std::span<const std::uint64_t>(organism.deaths));
  put_fields(out, organism.fields);
}

void get_organism(Reader& in, const Ecosystem& ecosystem,
                  std::span<const Phenotype* const> phenotypes, OrganismState& organism) {
  in.get(organism.key);
  in.get(organism.roster_index);
  require(organism.roster_index < phenotypes.size(), "an organism has no place in the roster");
  organism.phenotype = phenotypes[organism.roster_index];
  const std::string who = "organism " + std::to_string(organism.key) + ": ";
  compare(who + "states", in.text(), states_of(*organism.phenotype->tree));
  compare(who + "controller memory of a cell", std::to_string(in.get<std::uint32_t>()),
          std::to_string(organism.phenotype->program->memory_per_cell()));
  in.get(organism.next_id);
  in.get(organism.live);
  in.get(organism.shares);
  in.get(organism.ledger.founder_ambrosia);
  in.get(organism.ledger.founder_energy);
  each_sum(organism.ledger, [&](Sum& sum) { in.get(sum); });
  each_number(organism.outcome, [&](auto& value) { in.get(value); });
  in.get(organism.deaths, ecosystem.schema().causes.size());
  organism.fields = MorphogenFields(ecosystem.config().morphogens);
  get_fields(in, organism.fields);
}

void get_organisms(Reader& in, const Ecosystem& ecosystem,
                   std::span<const Phenotype* const> phenotypes, WorldState& world) {
  compare("organisms", std::to_string(in.get<std::uint32_t>()), std::to_string(phenotypes.size()));
  std::vector<bool> placed(phenotypes.size(), false);
  world.organisms.resize(phenotypes.size());
  for (std::size_t k = 0; k < world.organisms.size(); ++k) {
    OrganismState& organism = world.organisms[k];
    get_organism(in, ecosystem, phenotypes, organism);
    require(k == 0 || world.organisms[k - 1].key < organism.key, "organisms are out of order");
    require(!placed[organism.roster_index], "two organisms have one place in the roster");
    placed[organism.roster_index] = true;
  }
}

// ---- cells -------------------------------------------------------------------------------------

void put_cells(Writer& out, const WorldState& world) {
  const CellStore& cells = world.cells;
  out.put(cells.size());
  cells.each_column([&](const auto& column) {
    for (const std::uint32_t i : cells.order) out.put(column[i]);
  });
  for (std::uint32_t c = 0; c < cells.memory.channels(); ++c)
    for (const std::uint32_t i : cells.order) out.put(cells.memory.row(c)[i]);
  // Contacts by rank, in canonical order already.
  for (const std::uint32_t i : cells.order) {
    out.put(static_cast<std::uint32_t>(world.contacts.of(i).size()));
    for (const std::uint32_t j : world.contacts.of(i)) out.put(cells.rank[j]);
  }
}

void check_cell(const Schema& schema, const WorldState& world, std::uint32_t i) {
  const CellStore& cells = world.cells;
  require(cells.organism[i] < world.organisms.size(), "a cell is of no organism");
  const OrganismState& organism = world.organisms[cells.organism[i]];
  const std::size_t states = organism.phenotype->tree->states.size();
  require(cells.id[i] < organism.next_id, "a cell has a name that is still to be given");
  require(i == 0 || cells.organism[i - 1] < cells.organism[i] ||
              (cells.organism[i - 1] == cells.organism[i] && cells.id[i - 1] < cells.id[i]),
          "cells are out of order");
  require(cells.state[i] < states, "a cell is in no state of its tree");
  require(cells.action[i] <= Action::apoptosis, "a cell does what no cell can");
  require(cells.action[i] != Action::specialization || cells.target[i] < states,
          "a cell specializes into no state of its tree");
  require(cells.dead[i] <= 1, "a cell is neither dead nor alive");
  require(cells.cause[i] == no_cause || cells.cause[i] < schema.causes.size(),
          "a cell died of no cause");
}

void get_cells(Reader& in, const Ecosystem& ecosystem, WorldState& world) {
  CellStore& cells = world.cells;
  cells.values.resize(ecosystem.schema().cell_values.size());
  cells.damage.resize(ecosystem.schema().hazards.size());
  const auto count = in.get<std::uint32_t>();
  cells.each_column([&](auto& column) { in.get(column, count); });
  for (std::uint32_t i = 0; i < count; ++i) check_cell(ecosystem.schema(), world, i);

  std::vector<std::uint32_t> live(world.organisms.size());
  for (const std::uint16_t k : cells.organism) ++live[k];
  for (std::size_t k = 0; k < live.size(); ++k)
    require(live[k] == world.organisms[k].live, "an organism has another number of cells");

  std::uint32_t rows = 0;
  for (const OrganismState& organism : world.organisms)
    rows = std::max(rows, organism.phenotype->program->memory_per_cell());
  require(rows == 0 || count <= in.left() / sizeof(float) / rows, "it ends too early");
  cells.memory.reshape(rows, count);
  for (std::uint32_t c = 0; c < rows; ++c)
    for (std::uint32_t i = 0; i < count; ++i) in.get(cells.memory.row(c)[i]);
}

/// By rank: contacts of the k-th cell in canonical order.
std::vector<std::vector<std::uint32_t>> get_contacts(Reader& in, const CellStore& cells) {
  std::vector<std::vector<std::uint32_t>> contacts(cells.size());
  for (std::uint32_t k = 0; k < cells.size(); ++k) {
    in.get(contacts[k], in.get<std::uint32_t>());
    for (std::size_t n = 0; n < contacts[k].size(); ++n) {
      const std::uint32_t other = contacts[k][n];
      require(other < cells.size() && other != k, "a cell touches no other cell");
      require(n == 0 || contacts[k][n - 1] < other, "contacts are out of order");
    }
  }
  return contacts;
}

// ---- the environment ---------------------------------------------------------------------------

void put_environment(Writer& out, const Schema& schema, const WorldState& world) {
  for (const auto& grid : world.grids) out.put(std::span<const double>(grid));
  for (const TableStore& table : world.tables) {
    out.put(table.rows());
    for (Id c = 0; c < table.columns(); ++c) out.put(table.column(c));
  }
  out.put(std::span<const double>(world.scalars));
  // Who has nobody in charge is as the experiment says.
  for (std::size_t p = 0; p < world.parameters.size(); ++p)
    if (!schema.parameters[p].in_charge.empty()) out.put(world.parameters[p]);
}

void get_environment(Reader& in, const Schema& schema, WorldState& world) {
  for (const GridDeclaration& grid : schema.grids)
    in.get(world.grids.emplace_back(), std::size_t{grid.spec.columns} * grid.spec.rows);
  for (const TableDeclaration& declared : schema.tables) {
    TableStore& table = world.tables.emplace_back(declared.columns.size());
    const auto rows = in.get<std::uint32_t>();
    require(rows <= in.left() / sizeof(double) || declared.columns.empty(), "it ends too early");
    table.resize(rows);
    for (Id c = 0; c < table.columns(); ++c)
      for (double& value : table.column(c)) in.get(value);
  }
  in.get(world.scalars, schema.scalars.size());
  for (const VariableParameter& parameter : schema.parameters) {
    double& value = world.parameters.emplace_back(parameter.spec.value);
    if (!parameter.in_charge.empty()) in.get(value);
  }
}

/// What lies between the header and the checksum, once both are right.
std::span<const std::byte> opened(std::span<const std::byte> bytes) {
  const std::size_t head = magic.size() + sizeof(std::uint32_t);
  const auto same = [](std::byte byte, char c) { return byte == static_cast<std::byte>(c); };
  if (bytes.size() < magic.size() || !std::equal(magic.begin(), magic.end(), bytes.begin(),
                                                 [&](char c, std::byte b) { return same(b, c); }))
    throw SnapshotError("this is no saved state: it does not begin with " + std::string(magic));
  require(bytes.size() >= head + checksum_size, "it ends too early");
  const auto format = Reader(bytes.subspan(magic.size())).get<std::uint32_t>();
  if (format != snapshot_format)
    throw SnapshotError("the saved state has format " + std::to_string(format) +
                        "; this version reads format " + std::to_string(snapshot_format));
  const std::span<const std::byte> checked = bytes.first(bytes.size() - checksum_size);
  require(Reader(bytes.last(checksum_size)).get<std::uint64_t>() == checksum_of(checked),
          "its checksum is wrong; it was cut off or changed");
  return checked.subspan(head);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> vocabulary(const Ecosystem& ecosystem) {
  const Schema& schema = ecosystem.schema();
  const MorphogenGrid& morphogens = ecosystem.config().morphogens;
  const std::string size = std::to_string(morphogens.size);
  return {
      {"skills", listed(schema.skills, [](const Skill& skill) { return skill.name; })},
      {"sensors", listed(schema.sensors, [](const Sensor& sensor) { return sensor.name; })},
      {"cell values", listed(schema.cell_values, owned_name<CellValue>)},
      {"scalars", listed(schema.scalars, owned_name<Scalar>)},
      {"grids", listed(schema.grids, shape)},
      {"tables", listed(schema.tables,
                        [](const TableDeclaration& table) {
                          return owned_name(table) + " (" + listed(table.columns, itself) + ")";
                        })},
      {"causes of death", listed(schema.causes, itself)},
      {"hazards", listed(schema.hazards,
                         [&](const Hazard& hazard) {
                           return schema.causes[hazard.cause] + " (" +
                                  schema.skills[hazard.resistance_skill].name + ")";
                         })},
      {"varied parameters", varied(schema)},
      {"resources", listed(schema.resources, [](const Resource& r) { return r.name; })},
      {"morphogens", std::to_string(morphogens.kinds.size()) + " on " + size + " x " + size +
                         " squares of side " + number(morphogens.side)},
  };
}

std::vector<std::byte> save(const Simulation& simulation) {
  const WorldState& world = simulation.state();
  Writer out;
  out.raw(magic);
  out.put(snapshot_format);
  put_vocabulary(out, simulation.ecosystem());
  out.put(world.seed);
  out.put(world.step);
  out.put(world.inhabited_steps);
  out.put(world.finished);
  out.put(static_cast<std::uint32_t>(world.organisms.size()));
  for (const OrganismState& organism : world.organisms) put_organism(out, organism);
  put_cells(out, world);
  put_environment(out, simulation.ecosystem().schema(), world);
  return out.finish();
}

Simulation::Simulation(const Ecosystem& ecosystem, std::span<const Phenotype* const> phenotypes,
                       std::span<const std::byte> snapshot)
    : ecosystem_(ecosystem),
      view_(ecosystem, state_, inputs_, mechanics_),
      mechanics_(ecosystem.config().strangers) {
  if (phenotypes.empty()) throw std::invalid_argument("a roster needs an organism");
  Reader in(opened(snapshot));
  check_vocabulary(in, ecosystem);
  in.get(state_.seed);
  in.get(state_.step);
  in.get(state_.inhabited_steps);
  in.get(state_.finished);
  if (!state_.finished && state_.step >= ecosystem.config().max_steps)
    throw SnapshotError("the saved state comes before step " + std::to_string(state_.step) +
                        ", but the world ends after " +
                        std::to_string(ecosystem.config().max_steps) + " steps");
  get_organisms(in, ecosystem, phenotypes, state_);
  get_cells(in, ecosystem, state_);
  const auto contacts = get_contacts(in, state_.cells);
  get_environment(in, ecosystem.schema(), state_);
  require(in.left() == 0, "there is more in it than a world");

  // Cells come in canonical order; contacts follow them into the storage.
  reorganise();
  std::vector<std::uint32_t>& items = state_.contacts.items;
  for (const std::uint32_t k : state_.cells.rank) {
    const auto begin = static_cast<std::uint32_t>(items.size());
    for (const std::uint32_t other : contacts[k]) items.push_back(state_.cells.order[other]);
    state_.contacts.runs.push_back({begin, static_cast<std::uint32_t>(items.size())});
  }
}

}  // namespace somas::model
