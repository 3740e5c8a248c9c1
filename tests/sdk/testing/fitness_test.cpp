// Toys with one fault each, which check_fitness must find, and an honest one.
#include "somas/sdk/testing/fitness.hpp"

#include <atomic>
#include <functional>
#include <string>

#include <gmock/gmock.h>

namespace somas::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Scores the cells' mean number and stops when few are left, unless told otherwise.
class Toy final : public Fitness {
 public:
  struct Parameters {
    std::function<void(Declare&)> declare = [](Declare&) {};
    std::string objective = "mean cells";
    std::function<double(const Outcome&)> score = [](const Outcome& outcome) {
      return outcome.survival == 0 ? 0.0
                                   : outcome.cell_steps / static_cast<double>(outcome.survival);
    };
    std::function<bool(World&)> observe = [](World& world) { return world.cells().count < 3; };
  };
  explicit Toy(const Parameters& p) : p_(p) {}
  void declare(Declare& d) override { p_.declare(d); }
  [[nodiscard]] std::string_view objective() const override { return p_.objective; }
  [[nodiscard]] bool observe(World& world) const override { return p_.observe(world); }
  [[nodiscard]] double score(const Outcome& outcome) const override { return p_.score(outcome); }

 private:
  Parameters p_;
};

/// What is found after a change to the honest toy.
template <class Change>
Failures found(Change change) {
  Toy::Parameters parameters;
  change(parameters);
  return check_fitness<Toy>(parameters);
}

TEST(CheckFitness, FindsNothingInAnHonestOne) { EXPECT_THAT(check_fitness<Toy>(), IsEmpty()); }

TEST(CheckFitness, FindsPhasesAndSensors) {
  EXPECT_THAT(found([](auto& p) { p.declare = [](Declare& d) { d.acts_in(Phase::sense); }; }),
              ElementsAre("declare: a fitness observes: it has no phases and no sensors"));
}

TEST(CheckFitness, FindsAnObjectiveWithoutAName) {
  EXPECT_THAT(found([](auto& p) { p.objective = ""; }), ElementsAre("objective: has no name"));
}

TEST(CheckFitness, FindsScoresThatAreNoNumbers) {
  EXPECT_THAT(found([](auto& p) {
                p.score = [](const Outcome& o) {
                  return o.cell_steps / static_cast<double>(o.survival);
                };
              }),
              ElementsAre(HasSubstr("for an organism that lived 0 steps is not finite")));
}

TEST(CheckFitness, FindsScoresThatHangOnThePast) {
  static std::atomic<int> scored;
  EXPECT_THAT(found([](auto& p) { p.score = [](const Outcome&) { return ++scored; }; }),
              ElementsAre("score: equal outcomes score differently"));
}

TEST(CheckFitness, FindsAnObserverThatMeddles) {
  EXPECT_THAT(found([](auto& p) {
                p.declare = [](Declare& d) { static_cast<void>(d.scalar("seen", 0)); };
                p.observe = [](World& world) { return (world.scalar(0) += 1) < 0; };
              }),
              ElementsAre("observe: changes the world"));
  EXPECT_THAT(
      found([](auto& p) { p.observe = [](World& world) { return world.force_x().empty(); }; }),
      ElementsAre("observe: force_x belongs in act(forces)"));
}

TEST(CheckFitness, FindsAnObserverThatRemembers) {
  static int observed;
  EXPECT_THAT(found([](auto& p) { p.observe = [](World&) { return ++observed == 60; }; }),
              Contains("observe: stops another time in an equal world"));
}

}  // namespace
}  // namespace somas::testing
