#include <algorithm>
#include <vector>

#include "core/report/export.hpp"
#include "core/report/export_file.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using recording::Cells;
using recording::Ending;
using recording::Event;
using recording::Frame;
using recording::Grid;
using recording::Header;
using recording::Sink;
using recording::Summary;

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '"')
      safe += "&quot;";
    else
      safe += c;
  }
  return safe;
}

constexpr const char* declaration = "<?xml version=\"1.0\"?>\n";

std::string open_file(const char* type) {
  return std::string(declaration) + "<VTKFile type=\"" + type +
         "\" version=\"0.1\" byte_order=\"LittleEndian\">\n";
}

template <class T>
constexpr const char* vtk_type = "Float64";
template <>
constexpr const char* vtk_type<float> = "Float32";
template <>
constexpr const char* vtk_type<std::uint8_t> = "UInt8";
template <>
constexpr const char* vtk_type<std::uint16_t> = "UInt16";
template <>
constexpr const char* vtk_type<std::uint32_t> = "UInt32";
template <>
constexpr const char* vtk_type<std::int32_t> = "Int32";

template <class T>
std::string array(std::string_view name, const std::vector<T>& values, int components = 1) {
  std::string text = "<DataArray type=\"" + std::string(vtk_type<T>) + "\" Name=\"" +
                     escaped(name) + "\" NumberOfComponents=\"" + decimal(components) +
                     "\" format=\"ascii\">\n";
  for (const T value : values) text += decimal(value) + " ";
  return text + "\n</DataArray>\n";
}

/// Points with numbers, each a vertex, so that they show at once.
std::string points_file(const std::vector<float>& positions, const std::string& point_data) {
  const std::size_t count = positions.size() / 3;
  std::vector<std::int32_t> connectivity(count), offsets(count);
  for (std::size_t i = 0; i < count; ++i) {
    connectivity[i] = static_cast<std::int32_t>(i);
    offsets[i] = static_cast<std::int32_t>(i) + 1;
  }
  const std::string number = decimal(count);
  return open_file("PolyData") + "<PolyData>\n<Piece NumberOfPoints=\"" + number +
         "\" NumberOfVerts=\"" + number +
         "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<Points>\n" +
         array("position", positions, 3) + "</Points>\n<Verts>\n" +
         array("connectivity", connectivity) + array("offsets", offsets) +
         "</Verts>\n<PointData>\n" + point_data +
         "</PointData>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

template <class T>
std::vector<float> in_plane(const std::vector<T>& x, const std::vector<T>& y) {
  std::vector<float> positions;
  for (std::size_t i = 0; i < x.size(); ++i)
    positions.insert(positions.end(), {static_cast<float>(x[i]), static_cast<float>(y[i]), 0.0f});
  return positions;
}

std::string cells_file(const Header& header, const Cells& cells) {
  std::string data = array("id", cells.id) + array("parent", cells.parent) +
                     array("born", cells.born) + array("organism", cells.organism) +
                     array("state", cells.state) + array("action", cells.action) +
                     array("radius", cells.radius) + array("energy", cells.energy) +
                     array("ambrosia", cells.ambrosia) + array("pressure", cells.pressure);
  for (std::size_t h = 0; h < header.hazards.size(); ++h)
    data += array("damage." + header.hazards[h], cells.damage[h]);
  for (std::size_t v = 0; v < header.values.size(); ++v)
    data += array("value." + header.values[v], cells.values[v]);
  return points_file(in_plane(cells.x, cells.y), data);
}

/// Squares, with numbers each.
std::string squares_file(const Grid& grid, const std::string& cell_data) {
  const std::string extent = "0 " + decimal(grid.columns) + " 0 " + decimal(grid.rows) + " 0 0";
  return open_file("ImageData") + "<ImageData WholeExtent=\"" + extent + "\" Origin=\"" +
         decimal(grid.left) + " " + decimal(grid.bottom) + " 0\" Spacing=\"" + decimal(grid.side) +
         " " + decimal(grid.side) + " 1\">\n<Piece Extent=\"" + extent + "\">\n<CellData>\n" +
         cell_data + "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n";
}

/// Files of one kind over time, and the collection that lists them.
class Series {
 public:
  Series(fs::path directory, std::string name, std::string extension)
      : directory_(std::move(directory)),
        name_(std::move(name)),
        extension_(std::move(extension)) {}

  void add(std::uint64_t step, const std::string& content) {
    std::string number = decimal(step);
    number.insert(0, number.size() < 6 ? 6 - number.size() : 0, '0');
    const std::string file = name_ + "-" + number + extension_;
    ExportFile out(directory_ / file);
    out.write(content);
    out.close();
    list_ += "<DataSet timestep=\"" + decimal(step) + "\" part=\"0\" file=\"" + file + "\"/>\n";
  }
  void finish() const {
    ExportFile out(directory_ / (name_ + ".pvd"));
    out.write(open_file("Collection") + "<Collection>\n" + list_ + "</Collection>\n</VTKFile>\n");
    out.close();
  }

 private:
  fs::path directory_;
  std::string name_, extension_, list_;
};

class VtkExport final : public Sink {
 public:
  explicit VtkExport(fs::path directory)
      : directory_(std::move(directory)), cells_(directory_, "cells", ".vtp") {}

  void begin(const Header& header) override {
    header_ = header;
    for (std::size_t t = 0; t < header.tables.size(); ++t) {
      const auto& names = header.tables[t].columns;
      const auto place = [&](const char* name) {
        return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) -
                                        names.begin());
      };
      // What has no place cannot be shown in space.
      if (place("x") == names.size() || place("y") == names.size()) continue;
      tables_.push_back({t, place("x"), place("y"),
                         Series(directory_, "table-" + file_part(header.tables[t].name), ".vtp")});
    }
    for (const Grid& grid : header.grids)
      grids_.emplace_back(directory_, "grid-" + file_part(grid.name), ".vti");
    morphogens_.emplace_back(directory_, "morphogens", ".vti");
  }
  void event(const Event&) override {}
  void summary(const Summary&) override {}

  void frame(const Frame& frame) override {
    cells_.add(frame.step, cells_file(header_, frame.cells));
    for (PlacedTable& table : tables_) {
      const auto& columns = frame.tables[table.index].columns;
      std::string data;
      for (std::size_t c = 0; c < columns.size(); ++c)
        data += array(header_.tables[table.index].columns[c], columns[c]);
      table.series.add(frame.step, points_file(in_plane(columns[table.x], columns[table.y]), data));
    }
    if (!frame.has_fields) return;
    for (std::size_t g = 0; g < grids_.size(); ++g)
      grids_[g].add(frame.step, squares_file(header_.grids[g], array("content", frame.grids[g])));
    std::string data;
    for (std::size_t k = 0; k < frame.morphogens.size(); ++k)
      for (std::size_t kind = 0; kind < frame.morphogens[k].size(); ++kind)
        data += array("organism." + decimal(k) + "." + header_.morphogens[kind],
                      frame.morphogens[k][kind]);
    morphogens_.front().add(frame.step, squares_file(header_.morphogen_grid, data));
  }

  void finish(const Ending&) override {
    cells_.finish();
    for (const PlacedTable& table : tables_) table.series.finish();
    for (const Series& grid : grids_) grid.finish();
    for (const Series& morphogens : morphogens_) morphogens.finish();
  }

 private:
  struct PlacedTable {
    std::size_t index, x, y;  ///< of the table, and of its columns
    Series series;
  };

  fs::path directory_;
  Header header_;
  Series cells_;
  std::vector<PlacedTable> tables_;
  std::vector<Series> grids_, morphogens_;
};

}  // namespace

std::unique_ptr<Sink> vtk_export(const fs::path& directory) {
  return std::make_unique<VtkExport>(directory);
}

}  // namespace somas::report
