#include "core/report/page_data.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "core/run/json.hpp"

namespace somas::report {
namespace {

using Column = PageColumn;
using Type = PageColumn::Type;
using Encoding = PageColumn::Encoding;
using run::Json;

constexpr std::string_view magic = "SOMASPG1";

const char* name_of(Type type) {
  switch (type) {
    case Type::u8:
      return "u8";
    case Type::u16:
      return "u16";
    case Type::u32:
      return "u32";
    case Type::f32:
      break;
  }
  return "f32";
}

const char* name_of(Encoding encoding) {
  switch (encoding) {
    case Encoding::delta:
      return "delta";
    case Encoding::cell:
      return "cell";
    case Encoding::plain:
      break;
  }
  return "plain";
}

/// Quantities that cells have as columns of their own.
bool is_column_of_cells(const std::string& input) {
  return input == "pressure" || input == "energy" || input == "ambrosia";
}

std::string title_of(const recording::Header& header) {
  const recording::Provenance& from = header.provenance;
  std::string title = from.experiment.empty() ? "SOMAS" : from.experiment;
  title += ", champion of generation " + std::to_string(from.generation);
  if (from.population != 0) title += ", population " + std::to_string(from.population);
  return title;
}

std::string subtitle_of(const recording::Header& header, const Outcome& own) {
  const recording::Provenance& from = header.provenance;
  std::string text = "individual " + std::to_string(from.individual);
  if (!from.origin.empty()) text += " (" + from.origin + ")";
  text +=
      ", seed " + run::hex64(header.seed) + ", survived " + std::to_string(own.survival) + " steps";
  if (own.censored) text += ", alive at the end";
  if (!from.run.empty()) text += ", run " + from.run;
  return text;
}

/// Names of a channel over all organisms, whose trees may differ.
std::string name_of_output(const recording::Header& header, std::size_t channel) {
  std::vector<std::string> names;
  for (const recording::Organism& organism : header.organisms) {
    if (channel >= organism.outputs.size()) continue;
    const std::string& name = organism.outputs[channel];
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  std::string text = "output ";
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : " or ") + names[i];
  return text;
}

Json attribute(const std::string& name, const char* group, const PageColumn& column) {
  return {{"name", name}, {"group", group}, {"column", column.name()}};
}

Json organisms_of(const recording::Header& header) {
  Json organisms = Json::array();
  for (const recording::Organism& organism : header.organisms) {
    Json states = Json::array();
    for (const recording::State& state : organism.states)
      states.push_back(
          {{"name", state.name},
           {"parent", state.parent == recording::none ? Json(nullptr) : Json(state.parent)}});
    organisms.push_back({{"states", states}, {"outputs", organism.outputs}});
  }
  return organisms;
}

}  // namespace

// ---- a column -----------------------------------------------------------------------------------

template <class Value>
void PageColumn::add(Value value) {
  std::uint32_t bits = 0;
  if constexpr (std::is_floating_point_v<Value>)
    bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  else
    bits = static_cast<std::uint32_t>(value);
  for (std::size_t b = 0; b < width(); ++b)
    bytes_.push_back(static_cast<std::uint8_t>(bits >> (8 * b)));
}

std::uint32_t PageColumn::load(std::size_t i) const {
  std::uint32_t value = 0;
  for (std::size_t b = 0; b < width(); ++b)
    value |= std::uint32_t{bytes_[i * width() + b]} << (8 * b);
  return value;
}

std::string PageColumn::encode(const std::vector<std::int64_t>& previous) const {
  const std::size_t count = size();
  std::string planes(bytes_.size(), '\0');
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t value = load(i);
    if (encoding_ == Encoding::delta && i >= stride_) value -= load(i - stride_);
    if (encoding_ == Encoding::cell && previous[i] >= 0)
      value ^= load(static_cast<std::size_t>(previous[i]));
    for (std::size_t b = 0; b < width(); ++b)
      planes[b * count + i] = static_cast<char>(value >> (8 * b) & 255);
  }
  return planes;
}

// ---- what there is ------------------------------------------------------------------------------

void PageData::begin(const recording::Header& header) {
  header_ = header;
  frame_ = {Column("frame.step", Type::u32, Encoding::delta),
            Column("frame.rows", Type::u32, Encoding::delta),
            Column("frame.fields", Type::u32, Encoding::delta)};
  frame_[1].add(0u);
  declare_cells();
  for (std::size_t t = 0; t < header.tables.size(); ++t) {
    const std::vector<std::string>& columns = header.tables[t].columns;
    const auto x = std::find(columns.begin(), columns.end(), "x");
    const auto y = std::find(columns.begin(), columns.end(), "y");
    if (x == columns.end() || y == columns.end()) continue;
    const std::string name = "table." + std::to_string(tables_.size());
    tables_.push_back(
        {.index = t,
         .x = static_cast<std::size_t>(x - columns.begin()),
         .y = static_cast<std::size_t>(y - columns.begin()),
         .columns = {Column(name + ".rows", Type::u32, Encoding::delta),
                     Column(name + ".x", Type::f32), Column(name + ".y", Type::f32)}});
    tables_.back().columns[0].add(0u);
  }
  declare_fields();
  event_ = {Column("event.step", Type::u32, Encoding::delta),
            Column("event.kind", Type::u8),
            Column("event.organism", Type::u16),
            Column("event.cell", Type::u32),
            Column("event.parent", Type::u32),
            Column("event.state", Type::u16),
            Column("event.cause", Type::u16),
            Column("event.x", Type::f32),
            Column("event.y", Type::f32)};
  declare_summaries();
}

void PageData::declare_cells() {
  // Who is who comes first: the other columns are told apart by it.
  cell_ = {Column("cell.organism", Type::u16, Encoding::delta),
           Column("cell.id", Type::u32, Encoding::delta),
           Column("cell.parent", Type::u32, Encoding::cell),
           Column("cell.born", Type::u32, Encoding::cell),
           Column("cell.state", Type::u16, Encoding::cell),
           Column("cell.action", Type::u8, Encoding::cell)};
  for (const char* name : {"x", "y", "radius", "energy", "ambrosia", "pressure"})
    cell_.emplace_back(std::string("cell.") + name, Type::f32, Encoding::cell);
  const auto declare = [](std::vector<Column>& columns, const char* kind, std::size_t count) {
    for (std::size_t c = 0; c < count; ++c)
      columns.emplace_back("cell." + std::string(kind) + "." + std::to_string(c), Type::f32,
                           Encoding::cell);
  };
  declare(damage_, "damage", header_.hazards.size());
  declare(values_, "value", header_.values.size());
  for (std::size_t c = 0; c < header_.inputs.size(); ++c)
    if (!is_column_of_cells(header_.inputs[c])) input_channels_.push_back(c);
  declare(inputs_, "input", input_channels_.size());
  declare(outputs_, "output", header_.output_channels());
}

void PageData::declare_fields() {
  for (const recording::Grid& grid : header_.grids)
    fields_.push_back({.name = grid.name, .resource = grid.resource, .grid = grid});
  for (std::uint32_t o = 0; o < header_.organisms.size(); ++o)
    for (const std::string& name : header_.morphogens)
      fields_.push_back({.name = header_.organisms.size() == 1
                                     ? name
                                     : name + " of organism " + std::to_string(o + 1),
                         .resource = {},
                         .grid = header_.morphogen_grid,
                         .organism = o});
}

void PageData::declare_summaries() {
  summary_ = {Column("summary.step", Type::u32, Encoding::delta)};
  for (std::size_t o = 0; o < header_.organisms.size(); ++o)
    for (std::size_t s = 0; s < header_.organisms[o].states.size(); ++s)
      summary_.emplace_back("summary.population." + std::to_string(o) + "." + std::to_string(s),
                            Type::u32, Encoding::delta);
  for (const char* mean : {"summary.energy.", "summary.ambrosia."})
    for (std::size_t o = 0; o < header_.organisms.size(); ++o)
      summary_.emplace_back(mean + std::to_string(o), Type::f32);
  for (std::size_t g = 0; g < header_.grids.size(); ++g)
    summary_.emplace_back("summary.grid." + std::to_string(g), Type::f32);
}

// ---- what happens -------------------------------------------------------------------------------

void PageData::event(const recording::Event& event) {
  event_[0].add(event.step);
  event_[1].add(static_cast<std::uint8_t>(event.kind));
  event_[2].add(event.organism);
  event_[3].add(event.cell);
  event_[4].add(event.parent);
  event_[5].add(event.state);
  event_[6].add(event.cause);
  event_[7].add(event.x);
  event_[8].add(event.y);
}

void PageData::summary(const recording::Summary& summary) {
  std::size_t column = 0;
  summary_[column++].add(summary.step);
  for (const std::uint32_t count : summary.population) summary_[column++].add(count);
  for (const double mean : summary.energy) summary_[column++].add(mean);
  for (const double mean : summary.ambrosia) summary_[column++].add(mean);
  for (const double total : summary.grid_totals) summary_[column++].add(total);
}

void PageData::frame(const recording::Frame& frame) {
  ++frames_;
  link_to_last_frame(frame.cells);
  add_cells(frame.cells);
  add_tables(frame.tables);
  if (frame.has_fields) add_fields(frame);
  frame_[0].add(frame.step);
  frame_[1].add(previous_.size());
  frame_[2].add(field_frames_);
}

// Both frames ascend by (organism, id).
void PageData::link_to_last_frame(const recording::Cells& cells) {
  const std::size_t begin = previous_.size();
  std::vector<std::pair<std::uint16_t, std::uint32_t>> now;
  now.reserve(cells.size());
  std::size_t old = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto& cell = now.emplace_back(cells.organism[i], cells.id[i]);
    while (old < last_cells_.size() && last_cells_[old] < cell) ++old;
    const bool known = old < last_cells_.size() && last_cells_[old] == cell;
    previous_.push_back(known ? static_cast<std::int64_t>(last_begin_ + old) : -1);
  }
  last_begin_ = begin;
  last_cells_ = std::move(now);
}

void PageData::add_cells(const recording::Cells& cells) {
  cell_[0].add_all(cells.organism);
  cell_[1].add_all(cells.id);
  cell_[2].add_all(cells.parent);
  cell_[3].add_all(cells.born);
  cell_[4].add_all(cells.state);
  cell_[5].add_all(cells.action);
  cell_[6].add_all(cells.x);
  cell_[7].add_all(cells.y);
  cell_[8].add_all(cells.radius);
  cell_[9].add_all(cells.energy);
  cell_[10].add_all(cells.ambrosia);
  cell_[11].add_all(cells.pressure);
  for (std::size_t c = 0; c < damage_.size(); ++c) damage_[c].add_all(cells.damage[c]);
  for (std::size_t c = 0; c < values_.size(); ++c) values_[c].add_all(cells.values[c]);
  // A step without controllers (nobody lived) has no channels.
  const float none = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> absent(cells.size(), none);
  for (std::size_t c = 0; c < inputs_.size(); ++c)
    inputs_[c].add_all(input_channels_[c] < cells.inputs.size() ? cells.inputs[input_channels_[c]]
                                                                : absent);
  for (std::size_t c = 0; c < outputs_.size(); ++c)
    outputs_[c].add_all(c < cells.outputs.size() ? cells.outputs[c] : absent);
}

void PageData::add_tables(const std::vector<recording::TableRows>& tables) {
  for (DrawnTable& table : tables_) {
    const recording::TableRows& rows = tables[table.index];
    table.columns[1].add_all(rows.columns[table.x]);
    table.columns[2].add_all(rows.columns[table.y]);
    table.columns[0].add(table.columns[1].size());
  }
}

void PageData::add_fields(const recording::Frame& frame) {
  ++field_frames_;
  std::size_t field = 0;
  const auto add = [&](const std::vector<float>& content) {
    std::vector<float>& all = fields_[field++].content;
    all.insert(all.end(), content.begin(), content.end());
  };
  for (const std::vector<float>& content : frame.grids) add(content);
  for (const auto& organism : frame.morphogens)
    for (const std::vector<float>& content : organism) add(content);
}

void PageData::finish(const recording::Ending& ending) {
  ending_ = ending;
  finished_ = true;
}

// ---- the bytes ----------------------------------------------------------------------------------

// From 0, unless there is less, so that an even field does not look like none.
std::pair<float, float> PageData::range_of(const Field& field) const {
  float low = 0, high = 0;
  for (const float content : field.content) {
    low = std::min(low, content);
    high = std::max(high, content);
  }
  return {low, high > low ? high : low + 1};
}

PageColumn PageData::bytes_of(const Field& field, std::size_t index) const {
  const auto squares = static_cast<std::uint32_t>(field.grid.squares());
  PageColumn column("grid." + std::to_string(index), Type::u8, Encoding::delta, squares);
  const auto [low, high] = range_of(field);
  for (const float content : field.content)
    column.add(static_cast<std::uint8_t>(std::lround(255 * (content - low) / (high - low))));
  return column;
}

std::string PageData::bytes() const {
  if (!finished_) throw std::logic_error("the recorded life has not ended");
  std::vector<PageColumn> fields;
  for (std::size_t f = 0; f < fields_.size(); ++f) fields.push_back(bytes_of(fields_[f], f));

  std::vector<const PageColumn*> columns;
  const auto list = [&](const std::vector<PageColumn>& some) {
    for (const PageColumn& column : some) columns.push_back(&column);
  };
  for (const auto* some : {&frame_, &cell_, &damage_, &values_, &inputs_, &outputs_}) list(*some);
  for (const DrawnTable& table : tables_) list(table.columns);
  list(event_);
  list(summary_);
  list(fields);

  const std::string json = header(columns);
  std::string bytes(magic);
  for (std::size_t b = 0; b < 4; ++b) bytes += static_cast<char>(json.size() >> (8 * b) & 255);
  bytes += json;
  for (const PageColumn* column : columns) bytes += column->encode(previous_);
  return bytes;
}

std::string PageData::header(const std::vector<const PageColumn*>& columns) const {
  const Outcome own =
      header_.own < ending_.outcomes.size() ? ending_.outcomes[header_.own] : Outcome{};
  Json json{{"title", title_of(header_)},
            {"subtitle", subtitle_of(header_, own)},
            {"changes", titles_.changes},
            {"radius", header_.radius},
            {"max_steps", header_.max_steps},
            {"every", header_.every},
            {"own", header_.own},
            {"survival", own.survival},
            {"censored", own.censored},
            {"organisms", organisms_of(header_)},
            {"actions", header_.actions},
            {"causes", header_.causes}};

  Json attributes = Json::array();
  for (std::size_t c = 9; c < cell_.size(); ++c)
    attributes.push_back(attribute(cell_[c].name().substr(5), "cell", cell_[c]));
  for (std::size_t c = 0; c < damage_.size(); ++c)
    attributes.push_back(attribute("damage " + header_.hazards[c], "damage", damage_[c]));
  for (std::size_t c = 0; c < values_.size(); ++c)
    attributes.push_back(attribute(header_.values[c], "value", values_[c]));
  for (std::size_t c = 0; c < inputs_.size(); ++c)
    attributes.push_back(
        attribute("sensed " + header_.inputs[input_channels_[c]], "input", inputs_[c]));
  for (std::size_t c = 0; c < outputs_.size(); ++c)
    attributes.push_back(attribute(name_of_output(header_, c), "output", outputs_[c]));
  json["attributes"] = attributes;

  Json tables = Json::array();
  for (const DrawnTable& table : tables_) tables.push_back(header_.tables[table.index].name);
  json["tables"] = tables;

  Json grids = Json::array();
  for (const Field& field : fields_) {
    const auto [low, high] = range_of(field);
    Json grid{{"name", field.name},
              {"columns", field.grid.columns},
              {"rows", field.grid.rows},
              {"side", field.grid.side},
              {"left", field.grid.left},
              {"bottom", field.grid.bottom},
              {"low", low},
              {"high", high}};
    if (!field.resource.empty()) grid["resource"] = field.resource;
    if (field.organism != recording::none) grid["organism"] = field.organism;
    grids.push_back(grid);
  }
  json["grids"] = grids;

  Json outlines = Json::array();
  for (const recording::Outline& outline : header_.outlines)
    outlines.push_back(
        {{"name", outline.name}, {"closed", outline.closed}, {"x", outline.x}, {"y", outline.y}});
  json["outlines"] = outlines;

  Json blocks = Json::array();
  for (const PageColumn* column : columns) {
    Json block{{"name", column->name()},
               {"type", name_of(column->type())},
               {"count", column->size()},
               {"encoding", name_of(column->encoding())}};
    if (column->stride() != 1) block["stride"] = column->stride();
    blocks.push_back(block);
  }
  json["blocks"] = blocks;
  return json.dump();
}

}  // namespace somas::report
