#include "core/recording/file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/recording/life.hpp"

namespace somas::recording {
namespace {

namespace fs = std::filesystem;
using model::test::Bench;
using testing::HasSubstr;

std::vector<std::byte> bytes_of(const Recording& recording) {
  FileWriter writer;
  play(recording, writer);
  return writer.bytes();
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class RecordingFile : public testing::Test {
 protected:
  RecordingFile() {
    fs::create_directories(directory_);
    test::set_up(bench_, 60);
    recording_ = test::record(bench_, {.every = 3, .fields_every = 9});
    Provenance& from = recording_.header.provenance;
    from = {.experiment = "bu\"sy é", .run = "runs/x", .version = "1.2", .resolved_yaml = "a: 1\n"};
    from.generation = 7;
    from.individual = 99;
    from.parents = {3, 4};
    from.genome_json = std::string(100'000, 'j');
    from.controller_genes = {1, 2, 255};
    recording_.header.outlines = {
        {.name = "walls.wall", .x = {1, 2}, .y = {3, 4.5}, .closed = true}};
    write(bytes_of(recording_));
  }
  ~RecordingFile() override { fs::remove_all(directory_); }

  void write(const std::vector<std::byte>& bytes) const {
    std::ofstream out(file_, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  }
  [[nodiscard]] std::string error() const {
    try {
      (void)read(file_);
      return "";
    } catch (const FileError& failure) {
      return failure.what();
    }
  }

  fs::path directory_ = fs::path(testing::TempDir()) / ("recording" + std::to_string(::getpid()));
  fs::path file_ = directory_ / "life.h5";
  Bench bench_;
  Recording recording_;
};

// The schema and what a certain life puts into it, as another reader of HDF5 finds it. What changes
// here changes for everybody who reads recordings: format_version and docs/recording.md go along.
// SOMAS_UPDATE_GOLDEN=1 writes the file anew.
TEST_F(RecordingFile, HoldsWhatTheGoldenFileSays) {
  const fs::path here = fs::path(SOMAS_SOURCE_DIR) / "tests/core/recording";
  const fs::path found = directory_ / "found.txt", golden = here / "recording.golden";
  const std::string command = "/usr/bin/python3 '" + (here / "describe.py").string() + "' '" +
                              file_.string() + "' >'" + found.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << "this needs python3-h5py";
  if (std::getenv("SOMAS_UPDATE_GOLDEN") != nullptr)
    fs::copy_file(found, golden, fs::copy_options::overwrite_existing);
  EXPECT_EQ(text_of(found), text_of(golden));
}

TEST_F(RecordingFile, ReadsBackWhatWasWritten) {
  const Recording back = read(file_);
  const Provenance &now = back.header.provenance, &then = recording_.header.provenance;
  EXPECT_EQ(now.experiment, then.experiment);
  EXPECT_EQ(now.run, then.run);
  EXPECT_EQ(now.version, then.version);
  EXPECT_EQ(now.resolved_yaml, then.resolved_yaml);
  EXPECT_EQ(now.generation, 7u);
  EXPECT_EQ(now.individual, 99u);
  EXPECT_EQ(now.parents, then.parents);
  EXPECT_EQ(now.genome_json, then.genome_json);
  EXPECT_EQ(now.controller_genes, then.controller_genes);
  EXPECT_TRUE(now.tree_genes.empty());
  EXPECT_EQ(back.header.every, 3u);
  EXPECT_EQ(back.header.fields_every, 9u);
  EXPECT_EQ(back.header.own, recording_.header.own);
  EXPECT_EQ(back.header.outlines.at(0).y, (std::vector<double>{3, 4.5}));

  ASSERT_EQ(back.frames.size(), recording_.frames.size());
  std::size_t cells = 0, rows = 0;
  for (std::size_t f = 0; f < back.frames.size(); ++f) {
    const Frame &is = back.frames[f], &was = recording_.frames[f];
    EXPECT_EQ(is.step, was.step);
    EXPECT_EQ(is.cells.id, was.cells.id);
    EXPECT_EQ(is.cells.parent, was.cells.parent);
    EXPECT_EQ(is.cells.born, was.cells.born);
    EXPECT_EQ(is.cells.organism, was.cells.organism);
    EXPECT_EQ(is.cells.state, was.cells.state);
    EXPECT_EQ(is.cells.target, was.cells.target);
    EXPECT_EQ(is.cells.action, was.cells.action);
    EXPECT_EQ(is.cells.x, was.cells.x);
    EXPECT_EQ(is.cells.y, was.cells.y);
    EXPECT_EQ(is.cells.radius, was.cells.radius);
    EXPECT_EQ(is.cells.energy, was.cells.energy);
    EXPECT_EQ(is.cells.ambrosia, was.cells.ambrosia);
    EXPECT_EQ(is.cells.pressure, was.cells.pressure);
    EXPECT_EQ(is.cells.damage, was.cells.damage);
    EXPECT_EQ(is.cells.values, was.cells.values);
    ASSERT_EQ(is.cells.outputs.size(), was.cells.outputs.size());
    for (std::size_t c = 0; c < is.cells.outputs.size(); ++c)
      EXPECT_TRUE(same_bits(is.cells.outputs[c], was.cells.outputs[c]));
    ASSERT_EQ(is.tables.size(), 1u);
    EXPECT_EQ(is.tables[0].columns, was.tables[0].columns);
    EXPECT_EQ(is.has_fields, was.has_fields);
    EXPECT_EQ(is.grids, was.grids);
    EXPECT_EQ(is.morphogens, was.morphogens);
    cells += is.cells.size();
    rows += is.tables[0].columns[0].size();
  }
  EXPECT_GT(cells, 100u);
  EXPECT_GT(rows, 0u);
  ASSERT_EQ(back.events.size(), recording_.events.size());
  for (std::size_t e = 0; e < back.events.size(); ++e) {
    EXPECT_EQ(back.events[e].step, recording_.events[e].step);
    EXPECT_EQ(back.events[e].kind, recording_.events[e].kind);
    EXPECT_EQ(back.events[e].cell, recording_.events[e].cell);
    EXPECT_EQ(back.events[e].cause, recording_.events[e].cause);
    EXPECT_EQ(back.events[e].x, recording_.events[e].x);
  }
  ASSERT_EQ(back.summaries.size(), recording_.summaries.size());
  for (std::size_t s = 0; s < back.summaries.size(); ++s) {
    EXPECT_EQ(back.summaries[s].population, recording_.summaries[s].population);
    EXPECT_EQ(back.summaries[s].energy, recording_.summaries[s].energy);
    EXPECT_EQ(back.summaries[s].grid_totals, recording_.summaries[s].grid_totals);
    EXPECT_EQ(back.summaries[s].flux.size(), recording_.summaries[s].flux.size());
  }
  EXPECT_EQ(back.ending.steps, 60u);
  EXPECT_EQ(back.ending.score, recording_.ending.score);
  EXPECT_EQ(back.ending.outcomes[1].divisions, recording_.ending.outcomes[1].divisions);
  EXPECT_EQ(bytes_of(back), bytes_of(recording_));  // and whatever is not named above
}

TEST_F(RecordingFile, IsTheSameBytesForTheSameLife) {
  Bench again;
  test::set_up(again, 60);
  Recording other = test::record(again, {.every = 3, .fields_every = 9});
  other.header.provenance = recording_.header.provenance;
  other.header.outlines = recording_.header.outlines;
  EXPECT_EQ(bytes_of(other), bytes_of(recording_));
}

TEST_F(RecordingFile, IsCompressed) {
  std::size_t raw = 0;
  for (const Frame& frame : recording_.frames) {
    raw += frame.cells.size() * (13 + frame.cells.outputs.size()) * 4;
    for (const auto& grid : frame.grids) raw += grid.size() * 4;
    for (const auto& organism : frame.morphogens)
      for (const auto& kind : organism) raw += kind.size() * 4;
  }
  EXPECT_LT(fs::file_size(file_), raw * 6 / 10);  // much of this life is noise
}

TEST_F(RecordingFile, TheHeaderCanBeReadAlone) {
  const Header header = read_header(file_);
  EXPECT_EQ(header.provenance.experiment, "bu\"sy é");
  EXPECT_EQ(header.organisms[1].states[1].name, "leaf");
}

TEST_F(RecordingFile, WithoutTheControllerHasNoColumnsOfIt) {
  Bench bench;
  test::set_up(bench, 10);
  write(bytes_of(test::record(bench, {.every = 1, .fields_every = 1, .controller = false})));
  const Recording back = read(file_);
  EXPECT_FALSE(back.header.controller);
  EXPECT_TRUE(back.frames[5].cells.outputs.empty());
}

TEST_F(RecordingFile, WhatIsNoRecordingIsRefusedByName) {
  EXPECT_EQ(error(), "");
  std::ofstream(file_) << "step,cells\n0,1\n";
  EXPECT_EQ(error(), file_.string() + ": not an HDF5 file");
  fs::remove(file_);
  EXPECT_EQ(error(), file_.string() + ": no such file");
  fs::create_directory(file_);
  EXPECT_EQ(error(), file_.string() + ": is no regular file");
}

TEST_F(RecordingFile, DamageIsAnErrorWhereverItIs) {
  const std::vector<std::byte> good = bytes_of(recording_);
  // Cut short.
  for (std::size_t part = 1; part < 8; ++part) {
    write({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(good.size() * part / 8)});
    EXPECT_THAT(error(), HasSubstr("life.h5: ")) << part;
  }
  // Flipped bytes: some change a value only; none may crash.
  std::size_t noticed = 0;
  for (std::size_t at = 0; at < good.size(); at += good.size() / 150) {
    std::vector<std::byte> bad = good;
    bad[at] ^= std::byte{0xFF};
    write(bad);
    noticed += error().empty() ? 0 : 1;
  }
  EXPECT_GT(noticed, 20u);
}

TEST_F(RecordingFile, NumbersThatNameNothingAreRefused) {
  Recording odd = recording_;
  odd.frames[4].cells.state[0] = 77;
  write(bytes_of(odd));
  EXPECT_THAT(error(), HasSubstr("damaged: a cell's organism, state or action"));
}

}  // namespace
}  // namespace somas::recording
