#include <cmath>
#include <optional>
#include <vector>

#include "core/report/export.hpp"
#include "core/report/export_file.hpp"
#include "core/run/csv.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using recording::Cells;
using recording::Ending;
using recording::Event;
using recording::EventKind;
using recording::Flux;
using recording::Frame;
using recording::Grid;
using recording::Header;
using recording::none;
using recording::Organism;
using recording::Provenance;
using recording::Sink;
using recording::State;
using recording::Summary;
using recording::Table;

constexpr const char* event_names[] = {"birth", "death", "refused_division", "specialization"};

/// No number is an empty field, which every reader takes for a missing value.
void add(run::CsvLine& line, float value) {
  if (std::isnan(value))
    line.add("");
  else
    line.add(value);
}

class CsvExport final : public Sink {
 public:
  explicit CsvExport(fs::path directory) : directory_(std::move(directory)) {}

  void begin(const Header& header) override {
    header_ = header;
    write_about();
    write_states();
    begin_cells();
    begin_summary();
    events_.emplace(directory_ / "events.csv");
    events_->write("step,event,organism,cell,parent,state,from,cause,x,y\n");
    flux_.emplace(directory_ / "flux.csv");
    flux_->write("step,from_organism,from_state,to_organism,to_state,amount\n");
    for (const Table& table : header.tables) {
      tables_.emplace_back(directory_ / ("table-" + file_part(table.name) + ".csv"));
      run::CsvLine line;
      line.add("step");
      for (const std::string& column : table.columns) line.add(column);
      tables_.back().write(line.take());
    }
    for (const Grid& grid : header.grids) {
      grids_.emplace_back(directory_ / ("grid-" + file_part(grid.name) + ".csv"));
      grids_.back().write("step,column,row,x,y,content\n");
    }
    morphogens_.emplace(directory_ / "morphogens.csv");
    morphogens_->write("step,organism,morphogen,column,row,x,y,concentration\n");
  }

  void event(const Event& event) override {
    run::CsvLine line;
    line.add(event.step)
        .add(event_names[static_cast<std::size_t>(event.kind)])
        .add(event.organism)
        .add(event.cell)
        .add(event.parent)
        .add(state_name(event.organism, event.state))
        .add(event.from == none ? std::string() : state_name(event.organism, event.from));
    if (event.kind != EventKind::death)
      line.add("");
    else
      line.add(event.cause == none ? std::string("wound") : header_.causes[event.cause]);
    events_->write(line.add(event.x).add(event.y).take());
  }

  void summary(const Summary& summary) override {
    run::CsvLine line;
    line.add(summary.step);
    for (const std::uint32_t cells : summary.population) line.add(cells);
    for (std::size_t k = 0; k < summary.energy.size(); ++k)
      line.add(summary.energy[k]).add(summary.ambrosia[k]);
    for (const double total : summary.grid_totals) line.add(total);
    summary_->write(line.take());
    for (const Flux& flux : summary.flux)
      flux_->write(line.add(summary.step)
                       .add(flux.from_organism)
                       .add(state_name(flux.from_organism, flux.from_state))
                       .add(flux.to_organism)
                       .add(state_name(flux.to_organism, flux.to_state))
                       .add(flux.amount)
                       .take());
  }

  void frame(const Frame& frame) override {
    for (std::size_t c = 0; c < frame.cells.size(); ++c) write_cell(frame, c);
    for (std::size_t t = 0; t < tables_.size(); ++t) write_rows(frame, t);
    if (!frame.has_fields) return;
    for (std::size_t g = 0; g < grids_.size(); ++g)
      write_squares(frame.step, header_.grids[g], frame.grids[g], grids_[g]);
    for (std::size_t k = 0; k < frame.morphogens.size(); ++k)
      for (std::size_t kind = 0; kind < frame.morphogens[k].size(); ++kind)
        write_morphogen(frame.step, k, kind, frame.morphogens[k][kind]);
  }

  void finish(const Ending&) override {
    for (std::optional<ExportFile>* file : {&cells_, &events_, &flux_, &summary_, &morphogens_})
      (*file)->close();
    for (ExportFile& file : tables_) file.close();
    for (ExportFile& file : grids_) file.close();
  }

 private:
  [[nodiscard]] const std::string& state_name(std::uint16_t organism, std::uint16_t state) const {
    return header_.organisms[organism].states[state].name;
  }

  void write_about() const {
    const Provenance& from = header_.provenance;
    ExportFile file(directory_ / "about.csv");
    run::CsvLine line;
    const auto row = [&](const char* key, const auto& value) {
      file.write(line.add(key).add(value).take());
    };
    row("key", "value");
    row("experiment", from.experiment);
    row("run", from.run);
    row("generation", from.generation);
    row("individual", from.individual);
    row("seed", header_.seed);
    row("somas_version", from.version);
    row("own_organism", header_.own);
    row("radius", header_.radius);
    row("first_step", header_.first_step);
    row("every", header_.every);
    row("fields_every", header_.fields_every);
    file.close();
  }

  void write_states() const {
    ExportFile file(directory_ / "states.csv");
    file.write("organism,state,parent,radius,capacity\n");
    run::CsvLine line;
    for (std::size_t k = 0; k < header_.organisms.size(); ++k)
      for (const State& state : header_.organisms[k].states)
        file.write(line.add(k)
                       .add(state.name)
                       .add(state.parent == none ? std::string()
                                                 : header_.organisms[k].states[state.parent].name)
                       .add(state.radius)
                       .add(state.capacity)
                       .take());
    file.close();
  }

  void begin_cells() {
    run::CsvLine line;
    for (const char* name : {"step", "organism", "id", "parent", "born", "state", "action",
                             "target", "x", "y", "radius", "energy", "ambrosia", "pressure"})
      line.add(name);
    for (const std::string& hazard : header_.hazards) line.add("damage." + hazard);
    for (const std::string& value : header_.values) line.add("value." + value);
    if (header_.controller) {
      for (const std::string& input : header_.inputs) line.add("in." + input);
      for (const std::string& output : output_names()) line.add("out." + output);
    }
    cells_.emplace(directory_ / "cells.csv");
    cells_->write(line.take());
  }

  /// Organisms with evolved trees have outputs of their own: then they are told by channel.
  [[nodiscard]] std::vector<std::string> output_names() const {
    std::vector<std::string> names = header_.organisms[0].outputs;
    for (const Organism& organism : header_.organisms)
      if (organism.outputs != names) names.clear();
    for (std::size_t c = names.size(); c < header_.output_channels(); ++c)
      names.push_back(decimal(c));
    return names;
  }

  void begin_summary() {
    run::CsvLine line;
    line.add("step");
    for (std::size_t k = 0; k < header_.organisms.size(); ++k)
      for (const State& state : header_.organisms[k].states)
        line.add("cells." + decimal(k) + "." + state.name);
    for (std::size_t k = 0; k < header_.organisms.size(); ++k)
      line.add("energy." + decimal(k)).add("ambrosia." + decimal(k));
    for (const Grid& grid : header_.grids) line.add("total." + grid.name);
    summary_.emplace(directory_ / "summary.csv");
    summary_->write(line.take());
  }

  void write_cell(const Frame& frame, std::size_t c) {
    const Cells& cells = frame.cells;
    const std::uint16_t organism = cells.organism[c];
    run::CsvLine line;
    line.add(frame.step)
        .add(organism)
        .add(cells.id[c])
        .add(cells.parent[c])
        .add(cells.born[c])
        .add(state_name(organism, cells.state[c]))
        .add(header_.actions[cells.action[c]])
        .add(cells.target[c] == none ? std::string() : state_name(organism, cells.target[c]));
    for (const auto* column :
         {&cells.x, &cells.y, &cells.radius, &cells.energy, &cells.ambrosia, &cells.pressure})
      line.add((*column)[c]);
    for (const auto* columns : {&cells.damage, &cells.values, &cells.inputs, &cells.outputs})
      for (const std::vector<float>& column : *columns) add(line, column[c]);
    cells_->write(line.take());
  }

  void write_rows(const Frame& frame, std::size_t t) {
    const auto& columns = frame.tables[t].columns;
    for (std::size_t row = 0; !columns.empty() && row < columns[0].size(); ++row) {
      run::CsvLine line;
      line.add(frame.step);
      for (const std::vector<double>& column : columns) line.add(column[row]);
      tables_[t].write(line.take());
    }
  }

  static void add_square(run::CsvLine& line, const Grid& grid, std::size_t square) {
    const std::size_t column = square % grid.columns, row = square / grid.columns;
    line.add(column)
        .add(row)
        .add(grid.left + (static_cast<double>(column) + 0.5) * grid.side)
        .add(grid.bottom + (static_cast<double>(row) + 0.5) * grid.side);
  }

  static void write_squares(std::uint64_t step, const Grid& grid, const std::vector<float>& content,
                            ExportFile& file) {
    for (std::size_t square = 0; square < content.size(); ++square) {
      run::CsvLine line;
      line.add(step);
      add_square(line, grid, square);
      file.write(line.add(content[square]).take());
    }
  }

  /// Most squares hold nothing; they are left out.
  void write_morphogen(std::uint64_t step, std::size_t organism, std::size_t kind,
                       const std::vector<float>& concentration) {
    for (std::size_t square = 0; square < concentration.size(); ++square) {
      if (concentration[square] == 0) continue;
      run::CsvLine line;
      line.add(step).add(organism).add(kind);
      add_square(line, header_.morphogen_grid, square);
      morphogens_->write(line.add(concentration[square]).take());
    }
  }

  fs::path directory_;
  Header header_;
  std::optional<ExportFile> cells_, events_, flux_, summary_, morphogens_;
  std::vector<ExportFile> tables_, grids_;
};

}  // namespace

std::unique_ptr<Sink> csv_export(const fs::path& directory) {
  return std::make_unique<CsvExport>(directory);
}

}  // namespace somas::report
