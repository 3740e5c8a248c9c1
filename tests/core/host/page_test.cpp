// Replay pages from the command line. What they show is tested in a browser (tests/web).
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/run/files.hpp"
#include "tests/core/host/host_process.hpp"
#include "tests/core/run/scratch.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;
using run::read_file;
using run::write_file;
using testing::HasSubstr;
using testing::Not;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

/// A run of toys in a/.
class ReplayPage : public testing::Test {
 protected:
  ReplayPage() {
    write_file(path("toy.yaml"),
               "somas: 1\nname: toy\nseed: 5\n"
               "plugins: [" SOMAS_BINARY_DIR
               "/tests/fixtures/plugins]\n"
               "world: {max_steps: 60, max_cells: 20, morphogens: {size: 9}}\n"
               "evolution: {population: 8, generations: 2}\n"
               "environments:\n"
               "  field: {plugin: toy_environment, hazard: 0.2, hazard_start: 20}\n"
               "specialization: {plugin: toy_tree}\n"
               "controller: {plugin: toy_controller}\n"
               "fitness: {plugin: toy_fitness}\n");
    EXPECT_EQ(host({"toy.yaml", "-q", "--out", "a"}), 0) << err_;
  }
  fs::path path(const std::string& name) const { return scratch_.path() / name; }
  int host(std::vector<std::string> arguments, rlim_t limit = 0) {
    test::HostProcess process(scratch_.path(), std::move(arguments), limit);
    const int code = process.wait();
    out_ = process.out();
    err_ = process.err();
    return code;
  }
  int replay(std::vector<std::string> arguments, rlim_t limit = 0) {
    arguments.insert(arguments.begin(), {"replay", "a"});
    return host(std::move(arguments), limit);
  }
  std::size_t lives_in(const std::string& page) const {
    return count(read_file(path(page)), "application/x-somas-recording\">");
  }

  test::Scratch scratch_;
  std::string out_, err_;
};

TEST_F(ReplayPage, IsOneFileAndAlwaysTheSame) {
  ASSERT_EQ(replay({"--html", "p.html"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("page: p.html, "));
  EXPECT_THAT(out_, HasSubstr("reproduced: "));
  EXPECT_EQ(lives_in("p.html"), 1u);
  ASSERT_EQ(replay({"--html", "q.html"}), 0) << err_;
  EXPECT_EQ(read_file(path("p.html")), read_file(path("q.html")));
}

TEST_F(ReplayPage, TakesFewerFramesWhenAsked) {
  ASSERT_EQ(replay({"--html", "p.html"}), 0) << err_;
  ASSERT_EQ(replay({"--html", "few.html", "--every", "10", "--fields-every", "20"}), 0) << err_;
  EXPECT_LT(fs::file_size(path("few.html")), fs::file_size(path("p.html")));
}

TEST_F(ReplayPage, ShowsASecondLifeBesideIt) {
  ASSERT_EQ(replay({"--html", "p.html", "--compare", "a:0"}), 0) << err_;
  EXPECT_EQ(lives_in("p.html"), 2u);
  EXPECT_THAT(out_, HasSubstr("compared with toy: champion of generation 0"));
  ASSERT_EQ(replay({"--html", "q.html", "--compare-set", "environments.field.hazard=0"}), 0)
      << err_;
  EXPECT_EQ(lives_in("q.html"), 2u);
  EXPECT_THAT(out_, HasSubstr("compared with toy: champion of generation 1"));
  EXPECT_THAT(out_, HasSubstr("what if:  survival 60 (alive at the end)"));
}

TEST_F(ReplayPage, OfAWhatIfOrFromMidLifeIsWritten) {
  ASSERT_EQ(replay({"--html", "p.html", "--set", "environments.field.hazard=0"}), 0) << err_;
  ASSERT_EQ(replay({"--html", "q.html", "--from-step", "5", "--wound", "0,0,0.5"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("page: q.html, "));
}

TEST_F(ReplayPage, RefusesWhatItCannotDo) {
  const auto refused = [&](std::vector<std::string> arguments, const std::string& message) {
    EXPECT_EQ(replay(std::move(arguments)), 2);
    EXPECT_THAT(err_, HasSubstr(message));
    EXPECT_FALSE(fs::exists(path("p.html")));
  };
  refused({"--compare", "a"}, "--compare requires --html");
  refused({"--every", "0", "--html", "p.html"}, "is not a whole number from 1");
  refused({"--html", "p.html", "--compare", "none:3"}, "there is no directory none");
  refused({"--html", "p.html", "--compare", "a:99"}, "generation 99 has no champion");
  refused({"--html", "p.html", "--compare-set", "environments.fild.hazard=0"}, "fild");
  refused({"--html", "p.html", "--csv", "./p.html"}, "name the same file");
  refused({"--html", "a/summary.json"}, "belongs to the run");
}

TEST_F(ReplayPage, LeavesNothingBehindWhenItCannotBeWritten) {
  EXPECT_EQ(replay({"--html", "none/p.html"}), 5);
  EXPECT_EQ(replay({"--html", "p.html"}, 4096), 5);
  EXPECT_FALSE(fs::exists(path("p.html")));
}

}  // namespace
}  // namespace somas
