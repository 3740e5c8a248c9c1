#include <algorithm>
#include <cctype>
#include <optional>

#include "core/report/export.hpp"
#include "core/report/export_file.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using recording::Cells;
using recording::Ending;
using recording::Event;
using recording::Frame;
using recording::Header;
using recording::Sink;
using recording::Summary;

/// Words of the format end at blanks and quotes.
std::string word(std::string_view name) {
  std::string safe(name);
  for (char& c : safe)
    if (c <= ' ' || c == '"' || c == '\'' || c == ':' || c == '=') c = '_';
  return safe.empty() ? "_" : safe;
}

/// Cells as atoms: their types are the states, their sizes the radii. (Not species: readers for
/// chemists, as ASE, know those of the periodic table only.)
class XyzExport final : public Sink {
 public:
  explicit XyzExport(const fs::path& directory) : file_(directory / "cells.xyz") {}

  void begin(const Header& header) override {
    header_ = header;
    const std::string edge = decimal(2 * header.radius), low = decimal(-header.radius);
    frame_of_ = "Lattice=\"" + edge + " 0 0 0 " + edge + " 0 0 0 2\" Origin=\"" + low + " " + low +
                " -1\" pbc=\"F F F\" Properties=type:S:1:pos:R:3:radius:R:1:id:I:1:parent:I:1:"
                "organism:I:1:born:I:1:action:S:1:energy:R:1:ambrosia:R:1:pressure:R:1";
    for (const std::string& hazard : header.hazards)
      frame_of_ += ":damage." + word(hazard) + ":R:1";
    for (const std::string& value : header.values) frame_of_ += ":value." + word(value) + ":R:1";
  }
  void event(const Event&) override {}
  void summary(const Summary&) override {}

  void frame(const Frame& frame) override {
    const Cells& cells = frame.cells;
    std::string text = decimal(cells.size()) + "\n" + frame_of_ + " Time=" + decimal(frame.step) +
                       " step=" + decimal(frame.step) + "\n";
    for (std::size_t c = 0; c < cells.size(); ++c) {
      text += word(header_.organisms[cells.organism[c]].states[cells.state[c]].name);
      for (const auto* column : {&cells.x, &cells.y}) text += " " + decimal((*column)[c]);
      text += " 0 " + decimal(cells.radius[c]) + " " + decimal(cells.id[c]) + " " +
              decimal(cells.parent[c]) + " " + decimal(cells.organism[c]) + " " +
              decimal(cells.born[c]) + " " + header_.actions[cells.action[c]];
      for (const auto* column : {&cells.energy, &cells.ambrosia, &cells.pressure})
        text += " " + decimal((*column)[c]);
      for (const auto* columns : {&cells.damage, &cells.values})
        for (const std::vector<float>& column : *columns) text += " " + decimal(column[c]);
      text += "\n";
    }
    file_.write(text);
  }
  void finish(const Ending&) override { file_.close(); }

 private:
  Header header_;
  ExportFile file_;
  std::string frame_of_;  ///< the line that describes a frame, but for its time
};

}  // namespace

std::unique_ptr<Sink> xyz_export(const fs::path& directory) {
  return std::make_unique<XyzExport>(directory);
}

}  // namespace somas::report
