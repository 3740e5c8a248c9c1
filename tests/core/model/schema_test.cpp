// Parameters that vary in time, and outlines: what environments declare and connect.
#include "core/model/schema.hpp"

#include <string>

#include <gtest/gtest.h>

#include "tests/core/model/support.hpp"

namespace somas::model::test {
namespace {

/// Declares the variable parameter `rate` and notes what it is in Phase::fields of every step.
NamedEnvironment reader(std::string name, std::vector<double>& seen, double value = 1) {
  auto toy = std::make_shared<ToyEnvironment>();
  auto id = std::make_shared<Id>(no_id);
  toy->on_declare = [=](Declare& d) {
    *id = d.parameter("rate", {.value = value, .minimum = 0, .maximum = 100});
    d.acts_in(Phase::fields);
  };
  toy->on_act = [=, &seen](Phase, World& world) { seen.push_back(world.parameter(*id)); };
  return {std::move(name), toy};
}

/// Has `of`.rate in charge and sets it by the step.
NamedEnvironment setter(std::string name, std::string of, std::function<double(World&)> value,
                        Phase phase = Phase::parameters) {
  auto toy = std::make_shared<ToyEnvironment>();
  auto variable = std::make_shared<Variable>();
  toy->on_declare = [=](Declare& d) { d.acts_in(phase); };
  toy->on_connect = [=](Connections& c) { *variable = c.vary(of, "rate"); };
  toy->on_act = [=](Phase, World& world) { world.set_parameter(variable->id, value(world)); };
  return {std::move(name), toy};
}

double by_step(World& world) { return static_cast<double>(10 * world.step()); }

std::string failure_of_start(Bench& bench) {
  try {
    bench.start();
    bench.steps(3);
  } catch (const PluginFailure& failure) {
    return failure.what();
  }
  return "";
}

TEST(VariableParameters, AreWhatTheExperimentSaysUntilSomebodySetsThem) {
  std::vector<double> seen;
  Bench bench;
  bench.free_living();
  bench.environments = {reader("it", seen, 7)};
  bench.start();
  bench.steps(2);
  EXPECT_EQ(seen, (std::vector<double>{7, 7}));
}

TEST(VariableParameters, AreSetBeforeAnybodyReadsThemWhateverTheOrder) {
  for (const bool reader_first : {true, false}) {
    std::vector<double> seen;
    Bench bench;
    bench.free_living();
    bench.environments = {setter("season", "it", by_step)};
    bench.environments.insert(reader_first ? bench.environments.begin() : bench.environments.end(),
                              reader("it", seen));
    bench.start();
    bench.steps(3);
    EXPECT_EQ(seen, (std::vector<double>{0, 10, 20}));
  }
}

TEST(VariableParameters, BelongToTheHashOnlyWhereSomebodyVariesThem) {
  std::vector<double> seen;
  const auto hash_of = [&](std::vector<NamedEnvironment> environments) {
    Bench bench;
    bench.free_living();
    bench.environments = std::move(environments);
    bench.start();
    bench.steps(1);
    return bench.simulation().hash();
  };
  EXPECT_EQ(hash_of({reader("it", seen, 1)}), hash_of({reader("it", seen, 2)}));
  const auto varied = [&](double value) {
    return hash_of({reader("it", seen), setter("season", "it", [=](World&) { return value; })});
  };
  EXPECT_NE(varied(1), varied(2));
}

TEST(VariableParameters, ThatNobodyDeclaresAreRefusedWithThoseThereAre) {
  std::vector<double> seen;
  Bench bench;
  bench.environments = {reader("one", seen), setter("season", "other", by_step),
                        reader("two", seen)};
  EXPECT_EQ(failure_of_start(bench),
            "season: connect: no environment has a variable parameter 'other.rate'; there are: "
            "one.rate, two.rate");
}

TEST(VariableParameters, AreInOneCharge) {
  std::vector<double> seen;
  Bench bench;
  bench.environments = {reader("it", seen), setter("first", "it", by_step),
                        setter("second", "it", by_step)};
  EXPECT_EQ(failure_of_start(bench), "second: connect: 'it.rate' is in charge of 'first' already");
}

TEST(VariableParameters, AreSetInTheirPhaseOnly) {
  std::vector<double> seen;
  Bench bench;
  bench.environments = {reader("it", seen), setter("season", "it", by_step, Phase::stress)};
  EXPECT_EQ(failure_of_start(bench),
            "season: act(stress) at step 0: set_parameter belongs in act(parameters)");
}

TEST(VariableParameters, StayInTheirRange) {
  for (const double value : {-1.0, 101.0, std::nan("")}) {
    std::vector<double> seen;
    Bench bench;
    bench.environments = {reader("it", seen),
                          setter("season", "it", [=](World&) { return value; })};
    EXPECT_EQ(failure_of_start(bench),
              "season: act(parameters) at step 0: set_parameter: 'it.rate' is out of its range");
  }
}

TEST(VariableParameters, AreSetByWhoeverHasThemInChargeOnly) {
  std::vector<double> seen;
  Bench bench;
  bench.environments = {reader("it", seen), acting("rogue", Phase::parameters,
                                                   [](World& w) { w.set_parameter(0, 1); })};
  EXPECT_EQ(failure_of_start(bench),
            "rogue: act(parameters) at step 0: set_parameter: 'it.rate' is not in its charge");
}

TEST(VariableParameters, AreInTheirOwnRangeFromTheStart) {
  std::vector<double> seen;
  Bench bench;
  bench.environments = {reader("it", seen, 101)};
  EXPECT_EQ(failure_of_start(bench),
            "it: declare: it: the parameter 'rate' is outside its own range");
}

TEST(Outlines, AreKeptForPictures) {
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [](Declare& d) {
    const std::array<Point, 3> corner{Point{0, 0}, Point{1, 0}, Point{1, 2}};
    d.outline("corner", corner, true);
  };
  Bench bench;
  bench.environments = {{"it", toy}};
  const std::vector<Outline>& outlines = bench.start().ecosystem().schema().outlines;
  ASSERT_EQ(outlines.size(), 1u);
  EXPECT_EQ(outlines[0].owner, "it");
  EXPECT_EQ(outlines[0].name, "corner");
  EXPECT_TRUE(outlines[0].closed);
  ASSERT_EQ(outlines[0].points.size(), 3u);
  EXPECT_EQ(outlines[0].points[2].y, 2);
}

TEST(Outlines, NeedFinitePoints) {
  auto toy = std::make_shared<ToyEnvironment>();
  toy->on_declare = [](Declare& d) {
    const std::array<Point, 2> line{Point{0, 0}, Point{std::nan(""), 0}};
    d.outline("line", line, false);
  };
  Bench bench;
  bench.environments = {{"it", toy}};
  EXPECT_EQ(failure_of_start(bench),
            "it: declare: it: the outline 'line' needs at least two points, all finite");
}

}  // namespace
}  // namespace somas::model::test
