#include "core/report/export.hpp"

#include <atomic>
#include <cstdlib>
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/recording/file.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "tests/core/recording/life.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas::report {
namespace {

namespace fs = std::filesystem;
using recording::Recording;
using somas::test::FullDisk;
using somas::test::Scratch;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

class Export : public testing::Test {
 protected:
  Export() {
    model::test::Bench bench;
    recording::test::set_up(bench, 41);
    recording_ = recording::test::record(bench, {.every = 4, .fields_every = 20});
    recording::FileWriter writer;
    recording::play(recording_, writer);
    const std::vector<std::byte> bytes = writer.bytes();
    run::write_file(file_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  [[nodiscard]] std::string text(const std::string& name) const {
    return run::read_file(out_ / name);
  }
  /// Of a table: by column, the text of each row.
  [[nodiscard]] std::map<std::string, std::vector<std::string>> table(
      const std::string& name) const {
    std::map<std::string, std::vector<std::string>> columns;
    const std::vector<std::string> lines = split(text(name), '\n');
    const std::vector<std::string> names = split(lines.at(0), ',');
    for (std::size_t l = 1; l < lines.size(); ++l) {
      std::vector<std::string> fields = split(lines[l], ',');
      fields.resize(names.size());
      for (std::size_t c = 0; c < names.size(); ++c) columns[names[c]].push_back(fields[c]);
    }
    return columns;
  }
  [[nodiscard]] std::vector<std::string> left_behind() const {
    return Scratch::names_in(scratch_.path());
  }

  Scratch scratch_;
  fs::path file_ = scratch_.path() / "life.h5", out_ = scratch_.path() / "out";
  Recording recording_;
};

TEST_F(Export, CsvHoldsEveryCellExactly) {
  EXPECT_EQ(export_recording(file_, ExportFormat::csv, out_), recording_.frames.size());
  EXPECT_THAT(
      Scratch::names_in(out_),
      ElementsAre("about.csv", "cells.csv", "events.csv", "flux.csv", "grid-growing.content.csv",
                  "morphogens.csv", "states.csv", "summary.csv", "table-fiery.sparks.csv"));
  const auto cells = table("cells.csv");
  std::size_t row = 0, numbers = 0;
  for (const recording::Frame& frame : recording_.frames)
    for (std::size_t c = 0; c < frame.cells.size(); ++c, ++row) {
      ASSERT_LT(row, cells.at("id").size());
      EXPECT_EQ(cells.at("step")[row], std::to_string(frame.step));
      EXPECT_EQ(cells.at("id")[row], std::to_string(frame.cells.id[c]));
      EXPECT_EQ(cells.at("organism")[row], std::to_string(frame.cells.organism[c]));
      EXPECT_EQ(cells.at("state")[row], frame.cells.state[c] == 0 ? "root" : "leaf");
      EXPECT_EQ(std::stof(cells.at("x")[row]), frame.cells.x[c]);
      EXPECT_EQ(std::stof(cells.at("ambrosia")[row]), frame.cells.ambrosia[c]);
      EXPECT_EQ(std::stof(cells.at("damage.fire")[row]), frame.cells.damage[0][c]);
      EXPECT_EQ(std::stof(cells.at("value.fiery.wounds")[row]), frame.cells.values[0][c]);
      const std::string& conversion = cells.at("out.conversion")[row];
      EXPECT_EQ(conversion.empty(), frame.cells.born[c] == frame.step && frame.cells.id[c] != 0);
      numbers += conversion.empty() ? 0 : 1;
    }
  EXPECT_EQ(row, cells.at("id").size());
  EXPECT_GT(numbers, 50u);
}

TEST_F(Export, CsvHoldsWhatHappened) {
  (void)export_recording(file_, ExportFormat::csv, out_);
  const auto events = table("events.csv");
  ASSERT_EQ(events.at("step").size(), recording_.events.size());
  std::size_t deaths = 0;
  for (std::size_t e = 0; e < recording_.events.size(); ++e) {
    const recording::Event& event = recording_.events[e];
    EXPECT_EQ(events.at("cell")[e], std::to_string(event.cell));
    const bool death = event.kind == recording::EventKind::death;
    EXPECT_EQ(events.at("event")[e] == "death", death);
    EXPECT_EQ(events.at("cause")[e], death ? recording_.header.causes[event.cause] : "");
    deaths += death ? 1 : 0;
  }
  EXPECT_GT(deaths, 3u);
  double amount = 0, written = 0;
  for (const recording::Summary& summary : recording_.summaries)
    for (const recording::Flux& one : summary.flux) amount += one.amount;
  const auto flux = table("flux.csv");
  for (const std::string& text : flux.at("amount")) written += std::strtod(text.c_str(), nullptr);
  EXPECT_DOUBLE_EQ(written, amount);
  EXPECT_EQ(table("summary.csv").at("cells.1.root").size(), 41u);
  // Frames with fields are those of steps 0, 20 and 40.
  EXPECT_EQ(table("grid-growing.content.csv").at("content").size(), 3u * 64 * 64);
}

TEST_F(Export, XyzHasAFrameForEveryFrame) {
  (void)export_recording(file_, ExportFormat::xyz, out_);
  std::istringstream in(text("cells.xyz"));
  for (const recording::Frame& frame : recording_.frames) {
    std::string line;
    ASSERT_TRUE(std::getline(in, line));
    ASSERT_EQ(line, std::to_string(frame.cells.size()));
    std::getline(in, line);
    EXPECT_THAT(line, HasSubstr("Lattice=\"15 0 0 0 15 0 0 0 2\" Origin=\"-7.5 -7.5 -1\""));
    EXPECT_THAT(line, HasSubstr(" Time=" + std::to_string(frame.step) + " "));
    // As many columns as the properties say.
    const std::string list = line.substr(line.find("Properties=") + 11);
    const std::vector<std::string> properties = split(list.substr(0, list.find(' ')), ':');
    std::size_t columns = 0;
    for (std::size_t p = 2; p < properties.size(); p += 3) columns += std::stoul(properties[p]);
    for (std::size_t c = 0; c < frame.cells.size(); ++c) {
      std::getline(in, line);
      const std::vector<std::string> fields = split(line, ' ');
      ASSERT_EQ(fields.size(), columns);
      EXPECT_EQ(fields[0], frame.cells.state[c] == 0 ? "root" : "leaf");
      EXPECT_EQ(std::stof(fields[1]), frame.cells.x[c]);
      EXPECT_EQ(std::stof(fields[2]), frame.cells.y[c]);
      EXPECT_EQ(std::stof(fields[4]), frame.cells.radius[c]);
      EXPECT_EQ(fields[5], std::to_string(frame.cells.id[c]));
    }
  }
  std::string rest;
  EXPECT_FALSE(std::getline(in, rest));
}

TEST_F(Export, AnEmptyDirectoryIsFilledAndAFullOneRefused) {
  fs::create_directory(out_);
  (void)export_recording(file_, ExportFormat::xyz, out_ / "");
  EXPECT_THAT(Scratch::names_in(out_), ElementsAre("cells.xyz"));
  try {
    (void)export_recording(file_, ExportFormat::xyz, out_);
    FAIL() << "overwritten";
  } catch (const run::UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("is not empty"));
  }
  EXPECT_THAT(left_behind(), ElementsAre("life.h5", "out"));
}

TEST_F(Export, AFullDiskLeavesNothing) {
  const FullDisk full(20'000);
  EXPECT_THROW((void)export_recording(file_, ExportFormat::csv, out_), run::WriteError);
  EXPECT_THAT(left_behind(), ElementsAre("life.h5"));
}

TEST_F(Export, AStopLeavesNothing) {
  const std::atomic<bool> stop = true;
  EXPECT_EQ(export_recording(file_, ExportFormat::vtp, out_, evaluation::StopToken(stop)),
            std::nullopt);
  EXPECT_THAT(left_behind(), ElementsAre("life.h5"));
}

TEST_F(Export, WhatIsNoRecordingIsBadInput) {
  run::write_file(file_, "no HDF5");
  try {
    (void)export_recording(file_, ExportFormat::csv, out_);
    FAIL() << "read";
  } catch (const run::UsageError& error) {
    EXPECT_EQ(error.what(), file_.string() + ": not an HDF5 file");
  }
  EXPECT_THAT(left_behind(), ElementsAre("life.h5"));
}

// Files are read by Python's parser; their numbers are compared with the recording's.
TEST_F(Export, VtkFilesAreWellFormedAndHoldTheNumbers) {
  (void)export_recording(file_, ExportFormat::vtp, out_);
  const fs::path script = fs::path(SOMAS_SOURCE_DIR) / "tests/core/report/read_vtk.py";
  const fs::path result = scratch_.path() / "read.txt";
  const std::string command = "/usr/bin/python3 '" + script.string() + "' '" + out_.string() +
                              "' > '" + result.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);

  std::ostringstream expected;
  for (const recording::Frame& frame : recording_.frames) {
    expected << "cells.pvd " << frame.step << " points " << frame.cells.size() << " ids";
    for (const std::uint32_t id : frame.cells.id) expected << ' ' << id;
    expected << '\n';
  }
  for (const recording::Frame& frame : recording_.frames)
    if (frame.has_fields)
      expected << "grid-growing.content.pvd " << frame.step << " squares 4096 of 64 64\n";
  for (const recording::Frame& frame : recording_.frames)
    if (frame.has_fields) expected << "morphogens.pvd " << frame.step << " squares 4225 of 65 65\n";
  EXPECT_EQ(run::read_file(result), expected.str());
  EXPECT_THAT(text("cells-000040.vtp"), HasSubstr("Name=\"value.fiery.wounds\""));
}

}  // namespace
}  // namespace somas::report
