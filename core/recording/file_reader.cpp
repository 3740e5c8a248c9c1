#include <algorithm>
#include <optional>

#include "core/recording/file.hpp"
#include "core/recording/hdf5.hpp"

namespace somas::recording {
namespace {

using hdf5::Error;
using hdf5::Handle;
using hdf5::Reader;

[[noreturn]] void damaged(const std::string& what) { throw Error("damaged: " + what); }

// ---- the header ---------------------------------------------------------------------------------

void check_format(const Handle& file) {
  if (!hdf5::has_attribute(file, "format") ||
      hdf5::read_text_attribute(file, "format") != "somas-recording")
    throw Error("an HDF5 file, but not a recording");
  const std::uint64_t version = hdf5::read_whole_attribute(file, "format_version");
  if (version != format_version)
    throw Error("a recording of format " + std::to_string(version) +
                "; this version reads format " + std::to_string(format_version));
}

Provenance read_provenance(const Handle& file) {
  Provenance to;
  to.experiment = hdf5::read_text_attribute(file, "experiment");
  to.run = hdf5::read_text_attribute(file, "run");
  to.version = hdf5::read_text_attribute(file, "somas_version");
  to.generation = hdf5::read_whole_attribute(file, "generation");
  to.population = static_cast<std::uint32_t>(hdf5::read_whole_attribute(file, "population"));
  to.individual = hdf5::read_whole_attribute(file, "individual");
  to.origin = hdf5::read_text_attribute(file, "origin");
  to.fitness = hdf5::read_number_attribute(file, "fitness");
  const Handle group = hdf5::open_group(file, "provenance");
  to.resolved_yaml = hdf5::read_text(group, "resolved.yaml");
  to.genome_json = hdf5::read_text(group, "genome.json");
  to.parents = hdf5::read_column<std::uint64_t>(group, "parents");
  to.controller_genes = hdf5::read_column<std::uint8_t>(group, "controller_genes");
  to.tree_genes = hdf5::read_column<std::uint8_t>(group, "tree_genes");
  return to;
}

Grid read_geometry(const Handle& group) {
  Grid grid;
  grid.name = hdf5::read_text_attribute(group, "name");
  grid.resource = hdf5::read_text_attribute(group, "resource");
  grid.columns = static_cast<std::uint32_t>(hdf5::read_whole_attribute(group, "columns"));
  grid.rows = static_cast<std::uint32_t>(hdf5::read_whole_attribute(group, "rows"));
  grid.side = hdf5::read_number_attribute(group, "side");
  grid.left = hdf5::read_number_attribute(group, "left");
  grid.bottom = hdf5::read_number_attribute(group, "bottom");
  return grid;
}

std::vector<Organism> read_organisms(const Handle& file) {
  const Handle group = hdf5::open_group(file, "organisms");
  const auto keys = hdf5::read_column<std::uint64_t>(group, "key");
  const auto seats = hdf5::read_column<std::uint32_t>(group, "seat");
  const Handle states = hdf5::open_group(file, "states");
  const auto of = hdf5::read_column<std::uint16_t>(states, "organism");
  const auto parent = hdf5::read_column<std::uint16_t>(states, "parent");
  const auto radius = hdf5::read_column<double>(states, "radius");
  const auto capacity = hdf5::read_column<double>(states, "capacity");
  const auto names = hdf5::read_texts(states, "name");
  const std::size_t slots = of.size();
  if (keys.empty() || seats.size() != keys.size() || parent.size() != slots ||
      radius.size() != slots || capacity.size() != slots || names.size() != slots ||
      !std::is_sorted(of.begin(), of.end()))
    damaged("organisms or states");

  std::vector<Organism> organisms(keys.size());
  for (std::size_t k = 0; k < keys.size(); ++k) {
    organisms[k].key = keys[k];
    organisms[k].seat = seats[k];
    organisms[k].outputs = hdf5::read_texts(group, "outputs." + std::to_string(k));
    organisms[k].first_slot =
        static_cast<std::uint32_t>(std::lower_bound(of.begin(), of.end(), k) - of.begin());
  }
  for (std::size_t s = 0; s < slots; ++s) {
    if (of[s] >= organisms.size()) damaged("states");
    organisms[of[s]].states.push_back(
        {.name = names[s], .parent = parent[s], .radius = radius[s], .capacity = capacity[s]});
  }
  return organisms;
}

std::vector<Outline> read_outlines(const Handle& file) {
  std::vector<Outline> outlines;
  const Handle group = hdf5::open_group(file, "outlines");
  const std::uint64_t count = hdf5::read_whole_attribute(group, "count");
  for (std::uint64_t o = 0; o < count; ++o) {
    const Handle one = hdf5::open_group(group, std::to_string(o));
    outlines.push_back({.name = hdf5::read_text_attribute(one, "name"),
                        .x = hdf5::read_column<double>(one, "x"),
                        .y = hdf5::read_column<double>(one, "y"),
                        .closed = hdf5::read_whole_attribute(one, "closed") != 0});
  }
  return outlines;
}

void read_names(const Handle& file, Header& header) {
  const Handle names = hdf5::open_group(file, "names");
  header.actions = hdf5::read_texts(names, "actions");
  header.causes = hdf5::read_texts(names, "causes");
  header.hazards = hdf5::read_texts(names, "hazards");
  header.values = hdf5::read_texts(names, "values");
  header.inputs = hdf5::read_texts(names, "inputs");
  header.morphogens = hdf5::read_texts(names, "morphogens");
  const Handle grids = hdf5::open_group(file, "grids");
  for (const std::string& name : hdf5::read_texts(names, "grids"))
    header.grids.push_back(read_geometry(hdf5::open_group(grids, hdf5::object_name(name))));
  const Handle tables = hdf5::open_group(file, "tables");
  for (const std::string& name : hdf5::read_texts(names, "tables")) {
    const Handle table = hdf5::open_group(tables, hdf5::object_name(name));
    header.tables.push_back({name, hdf5::read_texts(table, "columns")});
  }
}

Header header_in(const Handle& file) {
  check_format(file);
  Header header;
  header.provenance = read_provenance(file);
  header.seed = hdf5::read_whole_attribute(file, "seed");
  header.radius = hdf5::read_number_attribute(file, "radius");
  header.max_steps = hdf5::read_whole_attribute(file, "max_steps");
  header.first_step = hdf5::read_whole_attribute(file, "first_step");
  header.every = hdf5::read_whole_attribute(file, "every");
  header.fields_every = hdf5::read_whole_attribute(file, "fields_every");
  header.controller = hdf5::read_whole_attribute(file, "controller") != 0;
  header.own = static_cast<std::uint32_t>(hdf5::read_whole_attribute(file, "own"));
  header.organisms = read_organisms(file);
  if (header.own >= header.organisms.size()) damaged("own");
  read_names(file, header);
  header.outlines = read_outlines(file);
  header.morphogen_grid = read_geometry(hdf5::open_group(file, "morphogens"));
  return header;
}

// ---- what grows ---------------------------------------------------------------------------------

/// Damage must not lead whoever uses the numbers as indices astray.
void check_cells(const Header& header, const Cells& cells) {
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (cells.organism[c] >= header.organisms.size() ||
        cells.state[c] >= header.organisms[cells.organism[c]].states.size() ||
        cells.action[c] >= header.actions.size())
      damaged("a cell's organism, state or action");
}

void check_event(const Header& header, const Event& event) {
  if (event.kind > EventKind::specialization || event.organism >= header.organisms.size() ||
      event.state >= header.organisms[event.organism].states.size() ||
      (event.cause != none && event.cause >= header.causes.size()) ||
      (event.from != none && event.from >= header.organisms[event.organism].states.size()))
    damaged("an event");
}

void check_flux(const Header& header, const Flux& flux) {
  if (flux.from_organism >= header.organisms.size() ||
      flux.to_organism >= header.organisms.size() ||
      flux.from_state >= header.organisms[flux.from_organism].states.size() ||
      flux.to_state >= header.organisms[flux.to_organism].states.size())
    damaged("flux");
}

/// A column whose rows have `width` numbers.
template <class T>
Reader<T> column(const Handle& in, const std::string& name, std::uint64_t width = 1) {
  Reader<T> reader(in, name);
  if (reader.width() != width) damaged("the width of '" + name + "'");
  return reader;
}

/// From a row of channels per cell to channels of cells.
std::vector<std::vector<float>> channels_of(const std::vector<float>& rows, std::size_t cells,
                                            std::size_t channels) {
  std::vector<std::vector<float>> result(channels, std::vector<float>(cells));
  for (std::size_t c = 0; c < cells; ++c)
    for (std::size_t channel = 0; channel < channels; ++channel)
      result[channel][c] = rows[c * channels + channel];
  return result;
}

class CellReader {
 public:
  CellReader(const Handle& file, const Header& header)
      : group_(hdf5::open_group(file, "cells")), with_controller_(header.controller) {
    for (const std::string& hazard : header.hazards)
      damage_.push_back(column<float>(group_, hdf5::object_name("damage." + hazard)));
    for (const std::string& value : header.values)
      values_.push_back(column<float>(group_, hdf5::object_name("value." + value)));
    inputs_.emplace(column<float>(group_, "inputs", header.inputs.size()));
    outputs_.emplace(column<float>(group_, "outputs", header.output_channels()));
  }

  void read(std::uint64_t first, std::uint64_t count, Cells& cells) const {
    cells.id = id_.rows(first, count);
    cells.parent = parent_.rows(first, count);
    cells.born = born_.rows(first, count);
    cells.organism = organism_.rows(first, count);
    cells.state = state_.rows(first, count);
    cells.target = target_.rows(first, count);
    cells.action = action_.rows(first, count);
    cells.x = x_.rows(first, count);
    cells.y = y_.rows(first, count);
    cells.radius = radius_.rows(first, count);
    cells.energy = energy_.rows(first, count);
    cells.ambrosia = ambrosia_.rows(first, count);
    cells.pressure = pressure_.rows(first, count);
    cells.damage.clear();
    for (const Reader<float>& column : damage_) cells.damage.push_back(column.rows(first, count));
    cells.values.clear();
    for (const Reader<float>& column : values_) cells.values.push_back(column.rows(first, count));
    if (!with_controller_) return;
    cells.inputs = channels_of(inputs_->rows(first, count), count, inputs_->width());
    cells.outputs = channels_of(outputs_->rows(first, count), count, outputs_->width());
  }

 private:
  Handle group_;
  bool with_controller_;
  Reader<std::uint32_t> id_{group_, "id"}, parent_{group_, "parent"}, born_{group_, "born"};
  Reader<std::uint16_t> organism_{group_, "organism"}, state_{group_, "state"},
      target_{group_, "target"};
  Reader<std::uint8_t> action_{group_, "action"};
  Reader<float> x_{group_, "x"}, y_{group_, "y"}, radius_{group_, "radius"},
      energy_{group_, "energy"}, ambrosia_{group_, "ambrosia"}, pressure_{group_, "pressure"};
  std::vector<Reader<float>> damage_, values_;
  std::optional<Reader<float>> inputs_, outputs_;
};

class TableReader {
 public:
  TableReader(const Handle& tables, const Table& table)
      : group_(hdf5::open_group(tables, hdf5::object_name(table.name))) {
    for (const std::string& name : table.columns)
      columns_.push_back(column<double>(group_, hdf5::object_name("column." + name)));
  }
  [[nodiscard]] TableRows next(std::uint64_t count) {
    TableRows rows;
    for (const Reader<double>& column : columns_) rows.columns.push_back(column.rows(next_, count));
    next_ += count;
    return rows;
  }

 private:
  Handle group_;
  std::vector<Reader<double>> columns_;
  std::uint64_t next_ = 0;
};

class FieldReader {
 public:
  FieldReader(const Handle& file, const Header& header)
      : header_(header),
        grids_(hdf5::open_group(file, "grids")),
        morphogens_(hdf5::open_group(file, "morphogens")),
        concentration_(column<float>(
            morphogens_, "concentration",
            header.organisms.size() * header.morphogens.size() * header.morphogen_grid.squares())) {
    for (const Grid& grid : header.grids)
      contents_.push_back(column<float>(hdf5::open_group(grids_, hdf5::object_name(grid.name)),
                                        "content", grid.squares()));
  }

  void next(Frame& frame) {
    for (const Reader<float>& content : contents_) frame.grids.push_back(content.rows(next_, 1));
    const std::vector<float> all = concentration_.rows(next_, 1);
    auto from = all.begin();
    const auto squares = static_cast<std::ptrdiff_t>(header_.morphogen_grid.squares());
    for (std::size_t k = 0; k < header_.organisms.size(); ++k) {
      std::vector<std::vector<float>>& kinds = frame.morphogens.emplace_back();
      for (std::size_t kind = 0; kind < header_.morphogens.size(); ++kind, from += squares)
        kinds.emplace_back(from, from + squares);
    }
    ++next_;
  }

 private:
  const Header& header_;
  Handle grids_, morphogens_;
  Reader<float> concentration_;
  std::vector<Reader<float>> contents_;
  std::uint64_t next_ = 0;
};

class FrameReader {
 public:
  FrameReader(const Handle& file, const Header& header)
      : header_(header), cells_(file, header), fields_(file, header) {
    const Handle group = hdf5::open_group(file, "frames");
    steps_ = hdf5::read_column<std::uint32_t>(group, "step");
    first_cell_ = hdf5::read_column<std::uint64_t>(group, "first_cell");
    counts_ = hdf5::read_column<std::uint32_t>(group, "cells");
    has_fields_ = hdf5::read_column<std::uint8_t>(group, "has_fields");
    table_rows_ = column<std::uint32_t>(group, "table_rows", header.tables.size()).all();
    if (first_cell_.size() != steps_.size() || counts_.size() != steps_.size() ||
        has_fields_.size() != steps_.size() ||
        table_rows_.size() != steps_.size() * header.tables.size())
      damaged("frames");
    const Handle tables = hdf5::open_group(file, "tables");
    for (const Table& table : header.tables) tables_.emplace_back(tables, table);
  }

  /// The next frame, if it is of this step.
  [[nodiscard]] bool next(std::uint64_t step, Frame& frame) {
    if (next_ == steps_.size() || steps_[next_] != step) return false;
    frame = {};
    frame.step = step;
    cells_.read(first_cell_[next_], counts_[next_], frame.cells);
    check_cells(header_, frame.cells);
    for (std::size_t t = 0; t < tables_.size(); ++t)
      frame.tables.push_back(tables_[t].next(table_rows_[next_ * tables_.size() + t]));
    frame.has_fields = has_fields_[next_] != 0;
    if (frame.has_fields) fields_.next(frame);
    ++next_;
    return true;
  }
  [[nodiscard]] bool at_end() const { return next_ == steps_.size(); }

 private:
  const Header& header_;
  CellReader cells_;
  FieldReader fields_;
  std::vector<TableReader> tables_;
  std::vector<std::uint32_t> steps_, counts_, table_rows_;
  std::vector<std::uint64_t> first_cell_;
  std::vector<std::uint8_t> has_fields_;
  std::size_t next_ = 0;
};

std::vector<Event> read_events(const Handle& file) {
  const Handle group = hdf5::open_group(file, "events");
  const auto step = hdf5::read_column<std::uint32_t>(group, "step");
  const std::uint64_t count = step.size();
  const auto kind = Reader<std::uint8_t>(group, "kind").rows(0, count);
  const auto organism = Reader<std::uint16_t>(group, "organism").rows(0, count);
  const auto cell = Reader<std::uint32_t>(group, "cell").rows(0, count);
  const auto parent = Reader<std::uint32_t>(group, "parent").rows(0, count);
  const auto state = Reader<std::uint16_t>(group, "state").rows(0, count);
  const auto from = Reader<std::uint16_t>(group, "from").rows(0, count);
  const auto cause = Reader<std::uint16_t>(group, "cause").rows(0, count);
  const auto x = Reader<float>(group, "x").rows(0, count);
  const auto y = Reader<float>(group, "y").rows(0, count);
  std::vector<Event> events(count);
  for (std::size_t e = 0; e < count; ++e)
    events[e] = {step[e],     static_cast<EventKind>(kind[e]),
                 organism[e], cell[e],
                 parent[e],   state[e],
                 from[e],     cause[e],
                 x[e],        y[e]};
  return events;
}

template <class T>
std::vector<T> row_of(const std::vector<T>& all, std::size_t row, std::size_t width) {
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(row * width);
  return {first, first + static_cast<std::ptrdiff_t>(width)};
}

std::vector<Summary> read_summaries(const Handle& file, const Header& header) {
  const Handle group = hdf5::open_group(file, "summary");
  const std::size_t organisms = header.organisms.size();
  const auto step = hdf5::read_column<std::uint32_t>(group, "step");
  const std::uint64_t count = step.size();
  const auto population = column<std::uint32_t>(group, "population", header.slots()).rows(0, count);
  const auto energy = column<double>(group, "energy", organisms).rows(0, count);
  const auto ambrosia = column<double>(group, "ambrosia", organisms).rows(0, count);
  const auto totals = column<double>(group, "grid_totals", header.grids.size()).rows(0, count);
  std::vector<Summary> summaries(count);
  for (std::size_t s = 0; s < count; ++s)
    summaries[s] = {.step = step[s],
                    .population = row_of(population, s, header.slots()),
                    .energy = row_of(energy, s, organisms),
                    .ambrosia = row_of(ambrosia, s, organisms),
                    .grid_totals = row_of(totals, s, header.grids.size()),
                    .flux = {}};
  return summaries;
}

void read_flux(const Handle& file, const Header& header, std::vector<Summary>& summaries) {
  const Handle group = hdf5::open_group(file, "flux");
  const auto step = hdf5::read_column<std::uint32_t>(group, "step");
  const std::uint64_t count = step.size();
  const auto from_organism = Reader<std::uint16_t>(group, "from_organism").rows(0, count);
  const auto from_state = Reader<std::uint16_t>(group, "from_state").rows(0, count);
  const auto to_organism = Reader<std::uint16_t>(group, "to_organism").rows(0, count);
  const auto to_state = Reader<std::uint16_t>(group, "to_state").rows(0, count);
  const auto amount = Reader<double>(group, "amount").rows(0, count);
  std::size_t at = 0;
  for (std::size_t f = 0; f < count; ++f) {
    while (at < summaries.size() && summaries[at].step < step[f]) ++at;
    if (at == summaries.size() || summaries[at].step != step[f]) damaged("flux");
    summaries[at].flux.push_back(
        {from_organism[f], from_state[f], to_organism[f], to_state[f], amount[f]});
    check_flux(header, summaries[at].flux.back());
  }
}

Ending read_ending(const Handle& file, std::size_t organisms) {
  Ending ending;
  ending.steps = hdf5::read_whole_attribute(file, "steps");
  ending.score = hdf5::read_number_attribute(file, "score");
  const Handle group = hdf5::open_group(file, "organisms");
  const auto survival = Reader<std::uint64_t>(group, "survival").rows(0, organisms);
  const auto censored = Reader<std::uint8_t>(group, "censored").rows(0, organisms);
  const auto divisions = Reader<std::uint64_t>(group, "divisions").rows(0, organisms);
  const auto specializations = Reader<std::uint64_t>(group, "specializations").rows(0, organisms);
  const auto refused = Reader<std::uint64_t>(group, "refused_divisions").rows(0, organisms);
  const auto final_cells = Reader<std::uint32_t>(group, "final_cells").rows(0, organisms);
  const auto peak_cells = Reader<std::uint32_t>(group, "peak_cells").rows(0, organisms);
  const auto cell_steps = Reader<double>(group, "cell_steps").rows(0, organisms);
  const auto share = Reader<double>(group, "biomass_share").rows(0, organisms);
  for (std::size_t k = 0; k < organisms; ++k)
    ending.outcomes.push_back({.survival = survival[k],
                               .censored = censored[k] != 0,
                               .divisions = divisions[k],
                               .specializations = specializations[k],
                               .refused_divisions = refused[k],
                               .final_cells = final_cells[k],
                               .peak_cells = peak_cells[k],
                               .cell_steps = cell_steps[k],
                               .biomass_share = share[k]});
  return ending;
}

void play(const Handle& file, Sink& sink) {
  const Header header = header_in(file);
  const std::vector<Event> events = read_events(file);
  std::vector<Summary> summaries = read_summaries(file, header);
  read_flux(file, header, summaries);
  for (const Event& event : events) check_event(header, event);
  FrameReader frames(file, header);
  const Ending ending = read_ending(file, header.organisms.size());

  sink.begin(header);
  std::size_t next = 0;
  Frame frame;
  for (const Summary& summary : summaries) {
    for (; next < events.size() && events[next].step <= summary.step; ++next)
      sink.event(events[next]);
    sink.summary(summary);
    if (frames.next(summary.step, frame)) sink.frame(frame);
  }
  for (; next < events.size(); ++next) sink.event(events[next]);
  if (!frames.at_end()) damaged("frames");
  sink.finish(ending);
}

/// Opens a file that is there; what the library says becomes a FileError.
template <class Use>
auto with_file(const std::filesystem::path& path, Use use) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw FileError(path, "no such file");
  if (!std::filesystem::is_regular_file(path, error)) throw FileError(path, "is no regular file");
  try {
    return use(hdf5::open_file(path));
  } catch (const Error& what) {
    throw FileError(path, what.what());
  }
}

}  // namespace

Header read_header(const std::filesystem::path& file) {
  return with_file(file, [](const Handle& opened) { return header_in(opened); });
}

void read(const std::filesystem::path& file, Sink& sink) {
  with_file(file, [&](const Handle& opened) { play(opened, sink); });
}

Recording read(const std::filesystem::path& file) {
  Collector collector;
  read(file, collector);
  return collector.take();
}

}  // namespace somas::recording
