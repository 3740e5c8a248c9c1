// What an experiment may say, but hardly means.
#include "core/experiment/warnings.hpp"

#include <gmock/gmock.h>

#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class Warnings : public Files {
 protected:
  // The grid of the faulty environment reaches from -25 to 25.
  std::vector<std::string> of_small_grid(const std::string& radius) {
    const auto file =
        write("e.yaml", "world: {radius: " + radius +
                            "}\nenvironments:\n"
                            "  field: {plugin: faulty_environment, fault: small_grid}\n"
                            "specialization: {plugin: toy_tree}\n"
                            "controller: {plugin: toy_controller}\n"
                            "fitness: {plugin: toy_fitness}\n");
    return warnings_of(load(file, {{}, {toy_plugins, bad_plugins / "faulty"}}));
  }
};

TEST_F(Warnings, NameAGridThatDoesNotCoverTheWorld) {
  EXPECT_THAT(of_small_grid("30"),
              ElementsAre("environments.field: its grid 'food' does not cover the world "
                          "(world.radius is 30): cells beyond it sense and find nothing there"));
}

TEST_F(Warnings, AreNoneWhereGridsCoverTheWorld) {
  EXPECT_THAT(of_small_grid("25"), IsEmpty());
  EXPECT_THAT(warnings_of(load_toy(write("toy.yaml", blocks))), IsEmpty());
}

}  // namespace
}  // namespace somas::experiment
