#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "core/recording/file.hpp"
#include "core/recording/hdf5.hpp"

namespace somas::recording {
namespace {

using hdf5::Column;
using hdf5::Handle;

/// The named member of every item, as a column or as texts.
template <class T, class Items, class Member>
void write_members(const Handle& in, const std::string& name, const Items& items, Member member) {
  std::vector<T> values;
  for (const auto& item : items) values.push_back(static_cast<T>(item.*member));
  if constexpr (std::is_same_v<T, std::string>)
    hdf5::write_texts(in, name, values);
  else
    hdf5::write_column<T>(in, name, values);
}

void write_provenance(const Handle& file, const Provenance& from) {
  hdf5::write_attribute(file, "experiment", from.experiment);
  hdf5::write_attribute(file, "run", from.run);
  hdf5::write_attribute(file, "somas_version", from.version);
  hdf5::write_attribute(file, "generation", from.generation);
  hdf5::write_attribute(file, "population", std::uint64_t{from.population});
  hdf5::write_attribute(file, "individual", from.individual);
  hdf5::write_attribute(file, "origin", from.origin);
  hdf5::write_attribute(file, "fitness", from.fitness);
  // What may be longer than an attribute can be.
  const Handle group = hdf5::create_group(file, "provenance");
  hdf5::write_text(group, "resolved.yaml", from.resolved_yaml);
  hdf5::write_text(group, "genome.json", from.genome_json);
  hdf5::write_column<std::uint64_t>(group, "parents", from.parents);
  hdf5::write_column<std::uint8_t>(group, "controller_genes", from.controller_genes);
  hdf5::write_column<std::uint8_t>(group, "tree_genes", from.tree_genes);
}

void write_names(const Handle& file, const Header& header) {
  const Handle group = hdf5::create_group(file, "names");
  hdf5::write_texts(group, "actions", header.actions);
  hdf5::write_texts(group, "causes", header.causes);
  hdf5::write_texts(group, "hazards", header.hazards);
  hdf5::write_texts(group, "values", header.values);
  hdf5::write_texts(group, "inputs", header.inputs);
  hdf5::write_texts(group, "morphogens", header.morphogens);
  write_members<std::string>(group, "grids", header.grids, &Grid::name);
  write_members<std::string>(group, "tables", header.tables, &Table::name);
  hdf5::write_texts(
      group, "events",
      std::vector<std::string>{"birth", "death", "refused_division", "specialization"});
}

void write_organisms(const Handle& file, const Header& header) {
  const Handle organisms = hdf5::create_group(file, "organisms");
  write_members<std::uint64_t>(organisms, "key", header.organisms, &Organism::key);
  write_members<std::uint32_t>(organisms, "seat", header.organisms, &Organism::seat);
  for (std::size_t k = 0; k < header.organisms.size(); ++k)
    hdf5::write_texts(organisms, "outputs." + std::to_string(k), header.organisms[k].outputs);

  const Handle states = hdf5::create_group(file, "states");
  std::vector<std::uint16_t> organism, state, parent;
  std::vector<double> radius, capacity;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < header.organisms.size(); ++k)
    for (std::size_t s = 0; s < header.organisms[k].states.size(); ++s) {
      const State& described = header.organisms[k].states[s];
      organism.push_back(static_cast<std::uint16_t>(k));
      state.push_back(static_cast<std::uint16_t>(s));
      parent.push_back(described.parent);
      radius.push_back(described.radius);
      capacity.push_back(described.capacity);
      names.push_back(described.name);
    }
  hdf5::write_column<std::uint16_t>(states, "organism", organism);
  hdf5::write_column<std::uint16_t>(states, "state", state);
  hdf5::write_column<std::uint16_t>(states, "parent", parent);
  hdf5::write_column<double>(states, "radius", radius);
  hdf5::write_column<double>(states, "capacity", capacity);
  hdf5::write_texts(states, "name", names);
}

void write_outlines(const Handle& file, const Header& header) {
  const Handle group = hdf5::create_group(file, "outlines");
  hdf5::write_attribute(group, "count", std::uint64_t{header.outlines.size()});
  for (std::size_t o = 0; o < header.outlines.size(); ++o) {
    const Handle outline = hdf5::create_group(group, std::to_string(o));
    hdf5::write_attribute(outline, "name", header.outlines[o].name);
    hdf5::write_attribute(outline, "closed", std::uint64_t{header.outlines[o].closed});
    hdf5::write_column<double>(outline, "x", header.outlines[o].x);
    hdf5::write_column<double>(outline, "y", header.outlines[o].y);
  }
}

void write_header(const Handle& file, const Header& header) {
  hdf5::write_attribute(file, "format", std::string_view("somas-recording"));
  hdf5::write_attribute(file, "format_version", std::uint64_t{format_version});
  hdf5::write_attribute(file, "seed", header.seed);
  hdf5::write_attribute(file, "radius", header.radius);
  hdf5::write_attribute(file, "max_steps", header.max_steps);
  hdf5::write_attribute(file, "first_step", header.first_step);
  hdf5::write_attribute(file, "every", header.every);
  hdf5::write_attribute(file, "fields_every", header.fields_every);
  hdf5::write_attribute(file, "controller", std::uint64_t{header.controller});
  hdf5::write_attribute(file, "own", std::uint64_t{header.own});
  write_provenance(file, header.provenance);
  write_names(file, header);
  write_organisms(file, header);
  write_outlines(file, header);
}

void write_geometry(const Handle& group, const Grid& grid) {
  hdf5::write_attribute(group, "name", grid.name);
  hdf5::write_attribute(group, "resource", grid.resource);
  hdf5::write_attribute(group, "columns", std::uint64_t{grid.columns});
  hdf5::write_attribute(group, "rows", std::uint64_t{grid.rows});
  hdf5::write_attribute(group, "side", grid.side);
  hdf5::write_attribute(group, "left", grid.left);
  hdf5::write_attribute(group, "bottom", grid.bottom);
}

// ---- what grows ---------------------------------------------------------------------------------

class CellSets {
 public:
  CellSets(const Handle& file, const Header& header)
      : group_(hdf5::create_group(file, "cells")), width_outputs_(header.output_channels()) {
    for (const std::string& hazard : header.hazards)
      damage_.emplace_back(group_, hdf5::object_name("damage." + hazard));
    for (const std::string& value : header.values)
      values_.emplace_back(group_, hdf5::object_name("value." + value));
    inputs_.emplace(group_, "inputs", hdf5::Shape{header.inputs.size()});
    outputs_.emplace(group_, "outputs", hdf5::Shape{width_outputs_});
  }

  void add(const Frame& frame) {
    const Cells& cells = frame.cells;
    const std::vector<std::uint32_t> steps(cells.size(), static_cast<std::uint32_t>(frame.step));
    step_.add(steps);
    id_.add(cells.id), parent_.add(cells.parent), born_.add(cells.born);
    organism_.add(cells.organism), state_.add(cells.state), target_.add(cells.target);
    action_.add(cells.action);
    x_.add(cells.x), y_.add(cells.y), radius_.add(cells.radius);
    energy_.add(cells.energy), ambrosia_.add(cells.ambrosia), pressure_.add(cells.pressure);
    for (std::size_t h = 0; h < damage_.size(); ++h) damage_[h].add(cells.damage[h]);
    for (std::size_t v = 0; v < values_.size(); ++v) values_[v].add(cells.values[v]);
    add_rows(*inputs_, cells.inputs, cells.size());
    add_rows(*outputs_, cells.outputs, cells.size());
  }

  void flush() {
    step_.flush();
    id_.flush(), parent_.flush(), born_.flush();
    organism_.flush(), state_.flush(), target_.flush(), action_.flush();
    x_.flush(), y_.flush(), radius_.flush();
    energy_.flush(), ambrosia_.flush(), pressure_.flush();
    for (Column<float>& column : damage_) column.flush();
    for (Column<float>& column : values_) column.flush();
    inputs_->flush();
    outputs_->flush();
  }

 private:
  /// From channels of cells to a row of channels per cell.
  void add_rows(Column<float>& to, const std::vector<std::vector<float>>& channels,
                std::size_t cells) {
    if (channels.empty()) return;
    rows_.resize(cells * channels.size());
    for (std::size_t channel = 0; channel < channels.size(); ++channel)
      for (std::size_t c = 0; c < cells; ++c)
        rows_[c * channels.size() + channel] = channels[channel][c];
    to.add_rows(rows_.data(), cells);
  }

  Handle group_;
  std::size_t width_outputs_;
  Column<std::uint32_t> step_{group_, "step"}, id_{group_, "id"}, parent_{group_, "parent"},
      born_{group_, "born"};
  Column<std::uint16_t> organism_{group_, "organism"}, state_{group_, "state"},
      target_{group_, "target"};
  Column<std::uint8_t> action_{group_, "action"};
  Column<float> x_{group_, "x"}, y_{group_, "y"}, radius_{group_, "radius"},
      energy_{group_, "energy"}, ambrosia_{group_, "ambrosia"}, pressure_{group_, "pressure"};
  std::vector<Column<float>> damage_, values_;
  std::optional<Column<float>> inputs_, outputs_;
  std::vector<float> rows_;
};

/// The rows of one table at all steps.
class TableSets {
 public:
  TableSets(const Handle& tables, const Table& table)
      : group_(hdf5::create_group(tables, hdf5::object_name(table.name))) {
    hdf5::write_attribute(group_, "name", table.name);
    hdf5::write_texts(group_, "columns", table.columns);
    for (const std::string& column : table.columns)
      columns_.emplace_back(group_, hdf5::object_name("column." + column));
  }
  void add(std::uint64_t step, const TableRows& rows) {
    const std::size_t count = rows.columns.empty() ? 0 : rows.columns[0].size();
    const std::vector<std::uint32_t> steps(count, static_cast<std::uint32_t>(step));
    step_.add(steps);
    for (std::size_t c = 0; c < columns_.size(); ++c) columns_[c].add(rows.columns[c]);
  }
  void flush() {
    step_.flush();
    for (Column<double>& column : columns_) column.flush();
  }

 private:
  Handle group_;
  Column<std::uint32_t> step_{group_, "step"};
  std::vector<Column<double>> columns_;
};

/// Grids and morphogens at the steps that have them.
class FieldSets {
 public:
  FieldSets(const Handle& file, const Header& header)
      : grids_(hdf5::create_group(file, "grids")),
        morphogens_(hdf5::create_group(file, "morphogens")) {
    for (const Grid& grid : header.grids) {
      const Handle group = hdf5::create_group(grids_, hdf5::object_name(grid.name));
      write_geometry(group, grid);
      contents_.emplace_back(group, "content", hdf5::Shape{grid.rows, grid.columns});
    }
    write_geometry(morphogens_, header.morphogen_grid);
    concentration_.emplace(morphogens_, "concentration",
                           hdf5::Shape{header.organisms.size(), header.morphogens.size(),
                                       header.morphogen_grid.rows, header.morphogen_grid.columns});
  }

  void add(const Frame& frame) {
    if (!frame.has_fields) return;
    step_.add(static_cast<std::uint32_t>(frame.step));
    for (std::size_t g = 0; g < contents_.size(); ++g)
      contents_[g].add_rows(frame.grids[g].data(), 1);
    all_.clear();
    for (const auto& organism : frame.morphogens)
      for (const std::vector<float>& kind : organism)
        all_.insert(all_.end(), kind.begin(), kind.end());
    concentration_->add_rows(all_.data(), 1);
  }

  void flush() {
    step_.flush();
    for (Column<float>& content : contents_) content.flush();
    concentration_->flush();
  }

 private:
  Handle grids_, morphogens_;
  Column<std::uint32_t> step_{grids_, "step"};
  std::vector<Column<float>> contents_;
  std::optional<Column<float>> concentration_;
  std::vector<float> all_;
};

class EventSets {
 public:
  explicit EventSets(const Handle& file) : group_(hdf5::create_group(file, "events")) {}
  void add(const Event& event) {
    step_.add(static_cast<std::uint32_t>(event.step));
    kind_.add(static_cast<std::uint8_t>(event.kind));
    cell_.add(event.cell), parent_.add(event.parent);
    organism_.add(event.organism), state_.add(event.state);
    from_.add(event.from), cause_.add(event.cause);
    x_.add(event.x), y_.add(event.y);
  }
  void flush() {
    step_.flush(), kind_.flush(), cell_.flush(), parent_.flush();
    organism_.flush(), state_.flush(), from_.flush(), cause_.flush();
    x_.flush(), y_.flush();
  }

 private:
  Handle group_;
  Column<std::uint32_t> step_{group_, "step"}, cell_{group_, "cell"}, parent_{group_, "parent"};
  Column<std::uint8_t> kind_{group_, "kind"};
  Column<std::uint16_t> organism_{group_, "organism"}, state_{group_, "state"},
      from_{group_, "from"}, cause_{group_, "cause"};
  Column<float> x_{group_, "x"}, y_{group_, "y"};
};

class SummarySets {
 public:
  SummarySets(const Handle& file, const Header& header)
      : group_(hdf5::create_group(file, "summary")), flux_(hdf5::create_group(file, "flux")) {
    population_.emplace(group_, "population", hdf5::Shape{header.slots()});
    energy_.emplace(group_, "energy", hdf5::Shape{header.organisms.size()});
    ambrosia_.emplace(group_, "ambrosia", hdf5::Shape{header.organisms.size()});
    grids_.emplace(group_, "grid_totals", hdf5::Shape{header.grids.size()});
  }
  void add(const Summary& summary) {
    const auto step = static_cast<std::uint32_t>(summary.step);
    step_.add(step);
    population_->add_rows(summary.population.data(), 1);
    energy_->add_rows(summary.energy.data(), 1);
    ambrosia_->add_rows(summary.ambrosia.data(), 1);
    grids_->add_rows(summary.grid_totals.data(), 1);
    for (const Flux& flux : summary.flux) {
      flux_step_.add(step);
      from_organism_.add(flux.from_organism), from_state_.add(flux.from_state);
      to_organism_.add(flux.to_organism), to_state_.add(flux.to_state);
      amount_.add(flux.amount);
    }
  }
  void flush() {
    step_.flush(), population_->flush(), energy_->flush(), ambrosia_->flush(), grids_->flush();
    flux_step_.flush(), from_organism_.flush(), from_state_.flush();
    to_organism_.flush(), to_state_.flush(), amount_.flush();
  }

 private:
  Handle group_, flux_;
  Column<std::uint32_t> step_{group_, "step"};
  std::optional<Column<std::uint32_t>> population_;
  std::optional<Column<double>> energy_, ambrosia_, grids_;
  Column<std::uint32_t> flux_step_{flux_, "step"};
  Column<std::uint16_t> from_organism_{flux_, "from_organism"}, from_state_{flux_, "from_state"},
      to_organism_{flux_, "to_organism"}, to_state_{flux_, "to_state"};
  Column<double> amount_{flux_, "amount"};
};

/// A line per frame: which rows are its.
class FrameSets {
 public:
  explicit FrameSets(const Handle& file, std::size_t tables)
      : group_(hdf5::create_group(file, "frames")) {
    table_rows_.emplace(group_, "table_rows", hdf5::Shape{tables});
  }
  void add(const Frame& frame) {
    step_.add(static_cast<std::uint32_t>(frame.step));
    first_cell_.add(next_cell_);
    cells_.add(static_cast<std::uint32_t>(frame.cells.size()));
    has_fields_.add(static_cast<std::uint8_t>(frame.has_fields));
    next_cell_ += frame.cells.size();
    std::vector<std::uint32_t> rows;
    for (const TableRows& table : frame.tables)
      rows.push_back(table.columns.empty() ? 0
                                           : static_cast<std::uint32_t>(table.columns[0].size()));
    table_rows_->add_rows(rows.data(), 1);
  }
  void flush() {
    step_.flush(), first_cell_.flush(), cells_.flush(), has_fields_.flush();
    table_rows_->flush();
  }

 private:
  Handle group_;
  std::uint64_t next_cell_ = 0;
  Column<std::uint32_t> step_{group_, "step"}, cells_{group_, "cells"};
  Column<std::uint64_t> first_cell_{group_, "first_cell"};
  Column<std::uint8_t> has_fields_{group_, "has_fields"};
  std::optional<Column<std::uint32_t>> table_rows_;
};

void write_ending(const Handle& file, const Ending& ending) {
  hdf5::write_attribute(file, "steps", ending.steps);
  hdf5::write_attribute(file, "score", ending.score);
  const Handle group = hdf5::open_group(file, "organisms");
  const auto& outcomes = ending.outcomes;
  write_members<std::uint64_t>(group, "survival", outcomes, &Outcome::survival);
  write_members<std::uint8_t>(group, "censored", outcomes, &Outcome::censored);
  write_members<std::uint64_t>(group, "divisions", outcomes, &Outcome::divisions);
  write_members<std::uint64_t>(group, "specializations", outcomes, &Outcome::specializations);
  write_members<std::uint64_t>(group, "refused_divisions", outcomes, &Outcome::refused_divisions);
  write_members<std::uint32_t>(group, "final_cells", outcomes, &Outcome::final_cells);
  write_members<std::uint32_t>(group, "peak_cells", outcomes, &Outcome::peak_cells);
  write_members<double>(group, "cell_steps", outcomes, &Outcome::cell_steps);
  write_members<double>(group, "biomass_share", outcomes, &Outcome::biomass_share);
}

}  // namespace

struct FileWriter::Sets {
  Sets(Handle opened, const Header& header)
      : file(std::move(opened)),
        frames(file, header.tables.size()),
        cells(file, header),
        fields(file, header),
        events(file),
        summaries(file, header) {
    const Handle group = hdf5::create_group(file, "tables");
    for (const Table& table : header.tables) tables.emplace_back(group, table);
    write_header(file, header);
  }

  Handle file;
  FrameSets frames;
  CellSets cells;
  FieldSets fields;
  EventSets events;
  SummarySets summaries;
  std::vector<TableSets> tables;
};

FileWriter::FileWriter() = default;
FileWriter::~FileWriter() = default;

void FileWriter::begin(const Header& header) {
  if (header.max_steps > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("a recording counts steps up to 2^32 - 1");
  sets_ = std::make_unique<Sets>(hdf5::create_in_memory(), header);
}

void FileWriter::event(const Event& event) { sets_->events.add(event); }

void FileWriter::summary(const Summary& summary) { sets_->summaries.add(summary); }

void FileWriter::frame(const Frame& frame) {
  sets_->frames.add(frame);
  sets_->cells.add(frame);
  sets_->fields.add(frame);
  for (std::size_t t = 0; t < sets_->tables.size(); ++t)
    sets_->tables[t].add(frame.step, frame.tables[t]);
}

void FileWriter::finish(const Ending& ending) {
  sets_->frames.flush();
  sets_->cells.flush();
  sets_->fields.flush();
  sets_->events.flush();
  sets_->summaries.flush();
  for (TableSets& table : sets_->tables) table.flush();
  write_ending(sets_->file, ending);
}

std::vector<std::byte> FileWriter::bytes() const { return hdf5::image_of(sets_->file); }

}  // namespace somas::recording
