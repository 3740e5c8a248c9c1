// The job script for Slurm, with a scontrol that only takes note.
#include <cstdlib>

#include <gmock/gmock.h>

#include "tests/core/host/toy_runs.hpp"

namespace somas {
namespace {

using testing::HasSubstr;

class Slurm : public test::ToyRuns {
 protected:
  Slurm() {
    std::filesystem::create_directory(path("bin"));
    run::write_file(path("bin/scontrol"), "#!/bin/sh\necho \"$@\" >>" + path("queue").string());
    std::filesystem::permissions(path("bin/scontrol"), std::filesystem::perms::owner_all);
  }
  /// The exit code of a shell script; $job is the job script.
  int shell(const std::string& script) {
    run::write_file(path("script.sh"),
                    "cd " + scratch_.path().string() +
                        "\nexport PATH=$PWD/bin:$PATH SLURM_JOB_ID=42 SOMAS_HOST=" SOMAS_BINARY_DIR
                        "/bin/somas-host\njob=" SOMAS_SOURCE_DIR "/experiments/job.slurm\n" +
                        script);
    const int status = std::system(
        ("bash " + path("script.sh").string() + " >" + path("log").string() + " 2>&1").c_str());
    return WEXITSTATUS(status);
  }
};

TEST_F(Slurm, AJobWhoseTimeIsUpIsQueuedAgainAndGoesOn) {
  ASSERT_EQ(shell("bash -n $job"), 0);
  ASSERT_EQ(shell(R"sh(
$job toy.yaml a --generations 1000000 --quiet &
job_shell=$!
for ((i = 0; i < 6000; ++i)); do
  (($(wc -l <a/generations.csv 2>/dev/null || echo 0) > 3)) && break
  sleep 0.01
done
kill -USR1 $job_shell
wait $job_shell
)sh"),
            143)
      << text("log");
  EXPECT_EQ(text("queue"), "requeue 42\n");
  EXPECT_THAT(text("a/summary.json"), HasSubstr("\"status\": \"stopped\""));

  // The next time it is a resume; made finite here.
  const std::string finished = std::to_string(generations_in("a"));
  ASSERT_EQ(host({"resume", "a", "--generations", finished}), 0) << err_;
  EXPECT_EQ(shell("$job toy.yaml a"), 0) << text("log");
  EXPECT_THAT(text("log"), HasSubstr("is complete"));
  EXPECT_EQ(text("queue"), "requeue 42\n");
}

TEST_F(Slurm, AJobThatFailsIsNotQueuedAgain) {
  EXPECT_EQ(shell("$job none.yaml a"), 2);
  EXPECT_FALSE(std::filesystem::exists(path("queue")));
}

}  // namespace
}  // namespace somas
