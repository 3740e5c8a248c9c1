// somas-host render and movie, on toy plugins; movies by the real ffmpeg.
#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using run::write_file;
using test::eventually;
using test::HostProcess;
using test::Scratch;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const std::string experiment_text =
    "somas: 1\n"
    "name: toy\n"
    "seed: 5\n"
    "plugins: [" SOMAS_BINARY_DIR
    "/tests/fixtures/plugins]\n"
    "world: {max_steps: 60, max_cells: 20, morphogens: {size: 9}}\n"
    "evolution: {population: 12, generations: 3}\n"
    "environments:\n"
    "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
    "specialization: {plugin: toy_tree}\n"
    "controller: {plugin: toy_controller}\n"
    "fitness: {plugin: toy_fitness}\n";

/// An environment variable, back to what it was afterwards.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name), before_(std::getenv(name)) {
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() { ::setenv(name_, before_.c_str(), 1); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::string before_;
};

class Figures : public testing::Test {
 protected:
  Figures() {
    write_file(path("toy.yaml"), experiment_text);
    EXPECT_EQ(host({"toy.yaml", "--out", "a", "-q"}), 0) << err_;
  }

  fs::path path(const std::string& name) const { return scratch_.path() / name; }
  std::string text(const std::string& name) const { return read_file(path(name)); }
  int host(std::vector<std::string> arguments, rlim_t limit = 0) {
    HostProcess process(scratch_.path(), std::move(arguments), limit);
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }
  void refused(std::vector<std::string> arguments, const std::string& because) {
    EXPECT_EQ(host(arguments), 2) << because;
    EXPECT_THAT(err_, HasSubstr(because));
    EXPECT_THAT(out_, IsEmpty());
  }
  /// What ffprobe says of the video, by name.
  std::string probe(const std::string& file, const std::string& entry) const {
    const std::string command =
        "ffprobe -v error -count_frames -select_streams v:0 -show_entries " + entry +
        " -of csv=p=0 " + path(file).string();
    std::string said;
    std::FILE* pipe = ::popen(command.c_str(), "r");
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += static_cast<char>(c);
    ::pclose(pipe);
    while (!said.empty() && (said.back() == '\n' || said.back() == ',')) said.pop_back();
    return said;
  }
  /// A program called ffmpeg that does this, alone on the PATH.
  std::string fake_ffmpeg(const std::string& script) {
    fs::create_directory(path("tools"));
    write_file(path("tools/ffmpeg"), "#!/bin/sh\n" + script);
    ::chmod(path("tools/ffmpeg").c_str(), 0755);
    return path("tools").string() + ":/bin:/usr/bin";
  }
  std::vector<std::string> half_files() const {
    std::vector<std::string> found;
    for (const std::string& name : Scratch::names_in(scratch_.path()))
      if (name.find(".tmp") != std::string::npos) found.push_back(name);
    return found;
  }

  Scratch scratch_;
  std::string out_, err_;
};

// ---- render ------------------------------------------------------------------------------------

TEST_F(Figures, EveryFigureStandsInTheRunUnlessToldOtherwise) {
  for (const std::string what :
       {"timelapse", "energy", "morphogens", "grid", "population", "phases", "lineage"}) {
    EXPECT_EQ(host({"render", "a", "--what", what}), 0) << err_;
    EXPECT_EQ(out_, "a/figures/" + what + "-gen-0002.svg\n");
    EXPECT_THAT(text("a/figures/" + what + "-gen-0002.svg"),
                AllOf(StartsWith("<?xml"), HasSubstr("un a (seed 5)"), HasSubstr("</svg>")))
        << what;
  }
  EXPECT_EQ(host({"render", "a", "--what", "evolution"}), 0) << err_;
  EXPECT_THAT(text("a/figures/evolution.svg"), HasSubstr("Run a (seed 5); 3 generations."));
}

TEST_F(Figures, FormatsFollowTheFilesName) {
  EXPECT_EQ(host({"render", "a", "--what", "population", "--out", "p.pdf"}), 0) << err_;
  EXPECT_THAT(text("p.pdf"), StartsWith("%PDF-"));
  EXPECT_EQ(host({"render", "a", "--what", "population", "--format", "png"}), 0) << err_;
  EXPECT_THAT(text("a/figures/population-gen-0002.png"), HasSubstr("PNG"));
}

TEST_F(Figures, StepsAndGenerationAreChosen) {
  EXPECT_EQ(host({"render", "a", "--what", "timelapse", "--generation", "0", "--steps", "0:10:5",
                  "--steps", "3", "--out", "p.svg"}),
            0)
      << err_;
  EXPECT_THAT(text("p.svg"),
              AllOf(HasSubstr("generation 0: champion"), HasSubstr("step 0\n"),
                    HasSubstr("step 3\n"), HasSubstr("step 5\n"), HasSubstr("step 10\n")));
}

TEST_F(Figures, AChangedLifeIsDrawnAndSaysSo) {
  EXPECT_EQ(host({"render", "a", "--what", "timelapse", "--set",
                  "environments.field.hazard_start=40", "--out", "p.svg"}),
            0)
      << err_;
  EXPECT_THAT(text("p.svg"), HasSubstr("what if environments.field.hazard_start=40."));
}

TEST_F(Figures, WhatCannotBeDrawnIsRefusedBeforeAnythingIsWritten) {
  refused({"render", "a", "--what", "timelaps"}, "did you mean 'timelapse'?");
  refused({"render", "a"}, "--what");
  refused({"render", "b", "--what", "energy"}, "b is no run directory");
  refused({"render", "b", "--what", "evolution"}, "b is no run directory");
  refused({"render", "a", "--what", "energy", "--steps", "5000"}, "is beyond the life");
  refused({"render", "a", "--what", "energy", "--steps", "1:0:1"}, "FIRST:LAST:DISTANCE");
  refused({"render", "a", "--what", "energy", "--steps", "1,x"}, "'x' is neither a step");
  refused({"render", "a", "--what", "lineage", "--steps", "5"}, "--steps says nothing about");
  refused({"render", "a", "--what", "energy", "--grid", "none"}, "--grid says nothing about");
  refused({"render", "a", "a", "--what", "energy"}, "--what energy is of one run");
  refused({"render", "a", "--what", "energy", "--generation", "7"}, "generation 7 has no champion");
  refused({"render", "a", "--what", "energy", "--out", "p.gif"}, "ends in .svg, .pdf or .png");
  refused({"render", "a", "--what", "energy", "--out", "p.png", "--format", "svg"}, "--format svg");
  refused({"render", "a", "--what", "energy", "--out", "a/champions/p.svg"}, "belongs to the run");
  refused({"render", "a", "--what", "energy", "--width", "20"}, "'20' is not a number from 40");
  EXPECT_FALSE(fs::exists(path("a/figures")));
}

TEST_F(Figures, ALifeThatIsNotTheRecordedOneIsNotDrawn) {
  const std::string file = "a/champions/gen-0002.json";
  std::string champion = text(file);
  const std::size_t at = champion.find("\"survival\": ");
  ASSERT_NE(at, std::string::npos);
  champion.insert(at + 12, "1");
  write_file(path(file), champion);
  EXPECT_EQ(host({"render", "a", "--what", "population"}), 4);
  EXPECT_THAT(err_, HasSubstr("does not live its recorded life again"));
  EXPECT_EQ(host({"movie", "a", "--out", "m.mp4"}), 4);
  EXPECT_FALSE(fs::exists(path("a/figures")));
  EXPECT_FALSE(fs::exists(path("m.mp4")));
}

TEST_F(Figures, ARecordingMakesTheFiguresOfItsLife) {
  ASSERT_EQ(host({"replay", "a", "--record", "r.h5", "--every", "1"}), 0) << err_;
  for (const std::string what : {"population", "phases"}) {
    ASSERT_EQ(host({"render", "a", "--what", what, "--out", "a.svg"}), 0) << err_;
    ASSERT_EQ(host({"render", "r.h5", "--what", what, "--out", "r.svg"}), 0) << err_;
    EXPECT_EQ(text("r.svg"), text("a.svg")) << what;
  }
  // Places of cells are single precision there; all else is the same.
  const auto words = [&](const std::string& name) {
    const std::string svg = text(name);
    const std::size_t from = svg.find("<title>");
    return svg.substr(from, svg.find("</desc>") - from);
  };
  const auto shapes = [&](const std::string& name) {
    std::size_t found = 0;
    const std::string svg = text(name);
    for (std::size_t at = svg.find("<path"); at != std::string::npos;
         at = svg.find("<path", at + 1))
      ++found;
    return found;
  };
  for (const std::string what : {"timelapse", "energy", "morphogens", "grid"}) {
    ASSERT_EQ(host({"render", "a", "--what", what, "--out", "a.svg"}), 0) << err_;
    ASSERT_EQ(host({"render", "r.h5", "--what", what, "--out", "r.svg"}), 0) << err_;
    EXPECT_EQ(words("r.svg"), words("a.svg")) << what;
    EXPECT_EQ(shapes("r.svg"), shapes("a.svg")) << what;
  }
}

TEST_F(Figures, ARecordingIsDrawnWhereItHasFrames) {
  ASSERT_EQ(host({"replay", "a", "--record", "r.h5", "--every", "4", "--fields-every", "8"}), 0);
  ASSERT_EQ(host({"render", "r.h5", "--what", "timelapse", "--out", "p.svg"}), 0) << err_;
  EXPECT_THAT(text("p.svg"), HasSubstr("step 8\n"));
  ASSERT_EQ(host({"render", "r.h5", "--what", "energy", "--steps", "4", "--out", "p.svg"}), 0);
  EXPECT_THAT(text("p.svg"), HasSubstr("step 4\n"));
  fs::remove(path("p.svg"));
  refused({"render", "r.h5", "--what", "energy", "--steps", "6", "--out", "p.svg"},
          "--steps: the recording has no frame of step 6; the nearest: 4 and 8");
  refused({"render", "r.h5", "--what", "timelapse", "--steps", "4", "--out", "p.svg"},
          "the frame of step 4 has neither grids nor morphogens; frames at steps divisible by 8");
  refused({"render", "r.h5", "--what", "energy"}, "r.h5 is a recording: --out must name");
  refused({"render", "r.h5", "--what", "evolution", "--out", "p.svg"}, "needs a run directory");
  refused({"render", "r.h5", "--what", "energy", "--set", "seed=1", "--out", "p.svg"},
          "--set needs a run directory; r.h5 is a recording");
  refused({"render", "toy.yaml", "--what", "energy", "--out", "p.svg"}, "toy.yaml: not an HDF5");
  EXPECT_FALSE(fs::exists(path("p.svg")));
}

TEST_F(Figures, AFigureIsWholeOrAsItWas) {
  write_file(path("p.svg"), "before");
  EXPECT_EQ(host({"render", "a", "--what", "timelapse", "--out", "p.svg"}, 1024), 5) << err_;
  EXPECT_EQ(text("p.svg"), "before");
  EXPECT_THAT(half_files(), IsEmpty());
}

// ---- movie -------------------------------------------------------------------------------------

TEST_F(Figures, AMovieHasAFrameForEveryStepAskedFor) {
  ASSERT_EQ(host({"movie", "a", "--out", "m.mp4", "--every", "2", "--fps", "10", "--width", "320"}),
            0)
      << err_;
  const std::size_t steps = [&] {
    EXPECT_EQ(host({"replay", "a", "--csv", "life.csv"}), 0);
    const std::string lines = text("life.csv");
    return static_cast<std::size_t>(std::count(lines.begin(), lines.end(), '\n')) - 1;
  }();
  const std::size_t frames = (steps + 1) / 2;
  EXPECT_EQ(probe("m.mp4", "stream=nb_read_frames"), std::to_string(frames));
  EXPECT_EQ(probe("m.mp4", "stream=codec_name,width,height,pix_fmt"), "h264,320,180,yuv420p");
  EXPECT_NEAR(std::stod(probe("m.mp4", "format=duration")), static_cast<double>(frames) / 10, 0.05);
  EXPECT_THAT(half_files(), IsEmpty());
}

TEST_F(Figures, AMovieIsWebMToo) {
  ASSERT_EQ(host({"movie", "a", "--out", "m.webm", "--every", "10", "--width", "320"}), 0) << err_;
  EXPECT_THAT(out_, StartsWith("m.webm: "));
  EXPECT_THAT(err_, HasSubstr("100 %"));
  EXPECT_THAT(probe("m.webm", "stream=codec_name"), "vp9");
}

TEST_F(Figures, ARecordingIsFilmed) {
  ASSERT_EQ(host({"replay", "a", "--record", "r.h5", "--every", "2", "--fields-every", "4"}), 0);
  ASSERT_EQ(host({"movie", "a", "--out", "a.mp4", "--every", "4", "--width", "320"}), 0) << err_;
  ASSERT_EQ(host({"movie", "r.h5", "--out", "r.mp4", "--every", "4", "--width", "320"}), 0) << err_;
  EXPECT_EQ(probe("r.mp4", "stream=nb_read_frames"), probe("a.mp4", "stream=nb_read_frames"));
  refused({"movie", "r.h5", "--out", "m.mp4", "--every", "3"}, "has a frame every 2 steps");
  refused({"movie", "r.h5", "--out", "m.mp4", "--generation", "1"}, "r.h5 is a recording");
  refused({"movie", "r.h5"}, "r.h5 is a recording: --out must name the movie");
}

TEST_F(Figures, WithoutFfmpegThereIsNoMovieButAReason) {
  const Variable nothing("PATH", path("nowhere").string());
  refused({"movie", "a", "--out", "m.mp4"},
          "a movie needs ffmpeg, which cannot be started: No such "
          "file or directory; install it");
  EXPECT_FALSE(fs::exists(path("m.mp4")));
}

TEST_F(Figures, WhatFfmpegComplainsOfIsShown) {
  write_file(path("m.mp4"), "before");
  const Variable tools("PATH", fake_ffmpeg("echo 'Unknown encoder: libx264' >&2; exit 3\n"));
  EXPECT_EQ(host({"movie", "a", "--out", "m.mp4"}), 5);
  EXPECT_THAT(err_, AllOf(HasSubstr("cannot write m.mp4: ffmpeg ended with code 3"),
                          HasSubstr("Unknown encoder: libx264")));
  EXPECT_EQ(text("m.mp4"), "before");
  EXPECT_THAT(half_files(), IsEmpty());
}

TEST_F(Figures, AFailureAtTheEndOfAMovieIsSeen) {
  const Variable tools("PATH", fake_ffmpeg("cat >/dev/null; echo 'no space' >&2; exit 1\n"));
  EXPECT_EQ(host({"movie", "a", "--out", "m.mp4"}), 5);
  EXPECT_THAT(err_, HasSubstr("no space"));
  EXPECT_FALSE(fs::exists(path("m.mp4")));
}

TEST_F(Figures, CtrlCLeavesNoHalfMovie) {
  // An encoder that writes and never gets enough.
  const Variable tools(
      "PATH", fake_ffmpeg("for last; do :; done; echo half >\"$last\"; head -c 1000 >/dev/null; "
                          "exec sleep 1000\n"));
  HostProcess process(scratch_.path(), {"movie", "a", "--out", "m.mp4"});
  ASSERT_TRUE(eventually([&] { return !half_files().empty(); }));
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 130);
  EXPECT_THAT(process.err(), HasSubstr("cancelled; there is no movie"));
  EXPECT_FALSE(fs::exists(path("m.mp4")));
  EXPECT_THAT(half_files(), IsEmpty());
}

TEST_F(Figures, MoviesOfTheWrongKindAreRefused) {
  refused({"movie", "a", "--out", "m.avi"}, "the name of a movie ends in .mp4 or .webm");
  refused({"movie", "a", "--out", "a/champions/m.mp4"}, "belongs to the run");
  refused({"movie", "b"}, "b is no run directory");
  refused({"movie", "a", "--fps", "0"}, "'0' is not a number from 1 to 240");
  refused({"movie", "a", "--every", "0"}, "not a whole number from 1");
}

}  // namespace
}  // namespace somas
