#include "plugins/specialization/tree/tree.hpp"

#include <gmock/gmock.h>

namespace somas::specialization {
namespace {

using testing::ElementsAre;
using testing::Pair;

const std::vector<SkillInfo> skills = {
    {"capacity", {}},
    {"diffusion", {.fallback = 1, .minimum = 0, .maximum = 1, .cost = 0}},
    {"production", {}},
    {"resistance", {.cost = 2}},
};

/// Keeps what a tree emits.
class Sink final : public TreeSink {
 public:
  struct Emitted {
    std::string name;
    StateSpec spec;
    std::vector<double> skills;
    std::vector<double> adhesion_with;
  };
  void add(const StateSpec& state) override {
    states.push_back({std::string(state.name),
                      state,
                      {state.skills.begin(), state.skills.end()},
                      {state.adhesion_with.begin(), state.adhesion_with.end()}});
  }
  std::uint32_t morphogens() const override { return 3; }
  std::vector<std::string> names() const {
    std::vector<std::string> list;
    for (const Emitted& e : states) list.push_back(e.name);
    return list;
  }
  std::vector<Emitted> states;
};

Sink grow(const Tree::Parameters& parameters) {
  Sink sink;
  Tree(parameters).grow({}, skills, sink);
  return sink;
}

/// Path and message of the ParameterError that the parameters end in.
std::pair<std::string, std::string> refusal(const Tree::Parameters& parameters) {
  try {
    grow(parameters);
  } catch (const ParameterError& error) {
    return {error.path(), error.what()};
  }
  return {"", "no refusal"};
}

Tree::State state(std::string name, std::string parent = "",
                  std::map<std::string, double> points = {}) {
  Tree::State s;
  s.name = std::move(name);
  s.parent = std::move(parent);
  s.skills = std::move(points);
  return s;
}

Tree::Parameters tree(std::vector<Tree::State> states) { return {std::move(states), {}}; }

TEST(Tree, EmitsEveryAttribute) {
  Tree::State n = state("N", "", {{"production", 3}, {"capacity", 10}});
  n.mass = 2;
  n.radius = 1.5;
  n.stiffness = 11;
  n.adhesion = 4;
  n.adhesion_range = 1.3;
  n.motility = -2;
  n.motility_signal = 2;
  n.quiescence_threshold = 0.1;
  n.division_threshold = 0.2;
  n.specialization_threshold = 0.3;
  n.apoptosis_threshold = 0.4;
  const Sink sink = grow(tree({n}));
  ASSERT_EQ(sink.states.size(), 1u);
  const StateSpec& spec = sink.states[0].spec;
  EXPECT_EQ(sink.states[0].name, "N");
  EXPECT_EQ(spec.key, stable_key("N"));
  EXPECT_EQ(spec.parent, no_state);
  EXPECT_EQ(spec.mass, 2);
  EXPECT_EQ(spec.radius, 1.5);
  EXPECT_EQ(spec.stiffness, 11);
  EXPECT_EQ(spec.adhesion, 4);
  EXPECT_EQ(spec.adhesion_range, 1.3);
  EXPECT_EQ(spec.motility, -2);
  EXPECT_EQ(spec.motility_signal, 2u);
  EXPECT_EQ(spec.quiescence_threshold, 0.1);
  EXPECT_EQ(spec.division_threshold, 0.2);
  EXPECT_EQ(spec.specialization_threshold, 0.3);
  EXPECT_EQ(spec.apoptosis_threshold, 0.4);
  // Skills in the order of the declarations, fallbacks for those left out.
  EXPECT_THAT(sink.states[0].skills, ElementsAre(10, 1, 3, 0));
}

TEST(Tree, HasTheDefaultsOfTheModel) {
  const Sink sink = grow(tree({state("N")}));
  const StateSpec& spec = sink.states[0].spec;
  EXPECT_EQ(spec.mass, 1);
  EXPECT_EQ(spec.radius, 1);
  EXPECT_EQ(spec.stiffness, 10);
  EXPECT_EQ(spec.adhesion, 3);
  EXPECT_EQ(spec.adhesion_range, 1.2);
  EXPECT_EQ(spec.motility, 0);
  EXPECT_EQ(spec.motility_signal, 0u);
  EXPECT_EQ(spec.quiescence_threshold, 0);
  EXPECT_EQ(spec.division_threshold, 0);
  EXPECT_EQ(spec.specialization_threshold, 0);
  EXPECT_EQ(spec.apoptosis_threshold, 0);
}

// ---- adhesion by pair of states -----------------------------------------------------------------

Tree::Parameters with_pairs(std::vector<Tree::AdhesionPair> pairs) {
  Tree::Parameters parameters = tree({state("X", "D"), state("D", "N"), state("N")});
  parameters.adhesion_pairs = std::move(pairs);
  return parameters;
}

TEST(Tree, EmitsThePairsWithTheLaterOfTheTwoStates) {
  // Emitted as N, D, X, whatever the order of the names in a pair.
  const Sink sink = grow(with_pairs({{"X", "N", 0.5}, {"D", "X", 7}}));
  EXPECT_THAT(sink.names(), ElementsAre("N", "D", "X"));
  EXPECT_THAT(sink.states[0].adhesion_with, ElementsAre());
  EXPECT_THAT(sink.states[1].adhesion_with, ElementsAre(testing::IsNan()));
  EXPECT_THAT(sink.states[2].adhesion_with, ElementsAre(0.5, 7));
}

TEST(Tree, LeavesEveryPairAtTheMeanUnlessToldOtherwise) {
  const Sink sink = grow(with_pairs({}));
  for (const Sink::Emitted& e : sink.states)
    EXPECT_THAT(e.adhesion_with, testing::Each(testing::IsNan()));
}

TEST(Tree, RefusesAPairWithAnUnknownState) {
  EXPECT_THAT(refusal(with_pairs({{"N", "D", 1}, {"DD", "N", 1}})),
              Pair("adhesion_pairs[1].first", "no state is called 'DD'; the states are X, D, N"));
  EXPECT_THAT(refusal(with_pairs({{"N", "", 1}})),
              Pair("adhesion_pairs[0].second", "no state is called ''; the states are X, D, N"));
}

TEST(Tree, RefusesAPairOfAStateWithItself) {
  EXPECT_THAT(refusal(with_pairs({{"D", "D", 1}})),
              Pair("adhesion_pairs[0].second",
                   "'D' is both of the pair; among its own cells a state has its `adhesion`"));
}

TEST(Tree, RefusesAPairTwiceInEitherOrder) {
  EXPECT_THAT(refusal(with_pairs({{"X", "N", 1}, {"N", "D", 1}, {"D", "N", 1}})),
              Pair("adhesion_pairs[2].second", "adhesion_pairs[1] is about 'D' and 'N' already"));
  EXPECT_THAT(refusal(with_pairs({{"X", "N", 1}, {"X", "N", 1}})),
              Pair("adhesion_pairs[1].second", "adhesion_pairs[0] is about 'X' and 'N' already"));
}

TEST(Tree, RefusesAMorphogenThatTheWorldDoesNotHave) {
  Tree::State d = state("D", "N");
  d.motility = 1;
  d.motility_signal = 2;
  EXPECT_EQ(refusal(tree({state("N"), d})).second, "no refusal");
  d.motility_signal = 3;
  EXPECT_THAT(refusal(tree({state("N"), d})),
              Pair("states[1].motility_signal",
                   "there is no morphogen 3: the world has morphogens 0 to 2"));
  d.motility = 0;
  EXPECT_EQ(refusal(tree({state("N"), d})).first, "states[1].motility_signal")
      << "a typing error, even where it does not matter yet";
}

TEST(Tree, IsNotHeritable) { EXPECT_EQ(Tree(tree({state("N")})).heritable(), nullptr); }

TEST(Tree, KeepsTheOrderOfTheListWhereParentsComeFirst) {
  const Sink sink = grow(tree({state("N"), state("D", "N"), state("S", "N"), state("X", "D")}));
  EXPECT_THAT(sink.names(), ElementsAre("N", "D", "S", "X"));
  EXPECT_EQ(sink.states[1].spec.parent, 0);
  EXPECT_EQ(sink.states[2].spec.parent, 0);
  EXPECT_EQ(sink.states[3].spec.parent, 1);
}

TEST(Tree, EmitsParentsFirstWhateverTheOrderOfTheList) {
  const Sink sink = grow(tree({state("X", "D"), state("S", "N"), state("D", "N"), state("N")}));
  EXPECT_THAT(sink.names(), ElementsAre("N", "S", "D", "X"));
  EXPECT_EQ(sink.states[0].spec.parent, no_state);
  EXPECT_EQ(sink.states[1].spec.parent, 0);
  EXPECT_EQ(sink.states[2].spec.parent, 0);
  EXPECT_EQ(sink.states[3].spec.parent, 2);
}

TEST(Tree, RefusesAnEmptyList) {
  EXPECT_THAT(refusal(tree({})), Pair("states", "a tree needs at least one state"));
}

TEST(Tree, RefusesMoreStatesThanSixtyFour) {
  std::vector<Tree::State> states = {state("N")};
  while (states.size() < 64) states.push_back(state("s" + std::to_string(states.size()), "N"));
  EXPECT_EQ(grow(tree(states)).states.size(), 64u);
  states.push_back(state("one more", "N"));
  EXPECT_THAT(refusal(tree(states)), Pair("states", "65 states; at most 64 are possible"));
}

TEST(Tree, RefusesAnEmptyName) {
  EXPECT_THAT(refusal(tree({state("N"), state("", "N")})),
              Pair("states[1].name", "a state needs a name"));
}

TEST(Tree, RefusesANameTwice) {
  EXPECT_THAT(refusal(tree({state("N"), state("D", "N"), state("D", "N")})),
              Pair("states[2].name", "states[1] has the name 'D' already"));
}

TEST(Tree, RefusesAnUnknownParent) {
  EXPECT_THAT(refusal(tree({state("nutritive"), state("defensive", "nutritve")})),
              Pair("states[1].parent",
                   "no state is called 'nutritve'; the states are nutritive, defensive"));
}

TEST(Tree, RefusesTwoRoots) {
  EXPECT_THAT(refusal(tree({state("N"), state("D")})),
              Pair("states[1].parent",
                   "'D' needs a parent: the root is 'N' already, and there is one only"));
}

TEST(Tree, RefusesToHaveNoRoot) {
  EXPECT_THAT(refusal(tree({state("N", "D"), state("D", "N")})),
              Pair("states", "no state is the root: exactly one must have no parent"));
}

TEST(Tree, RefusesALoopAndShowsIt) {
  EXPECT_THAT(refusal(tree({state("N"), state("tail", "C"), state("A", "C"), state("B", "A"),
                            state("C", "B")})),
              Pair("states[2].parent", "the parents run in a loop: A -> C -> B -> A"));
  EXPECT_THAT(refusal(tree({state("N"), state("A", "A")})),
              Pair("states[1].parent", "the parents run in a loop: A -> A"));
}

TEST(Tree, RefusesAnUnknownSkill) {
  EXPECT_THAT(
      refusal(tree({state("N"), state("D", "N"), state("S", "N", {{"prodution", 3}})})),
      Pair("states[2].skills.prodution",
           "no skill is called 'prodution'; skills come from the model and the environments "
           "in use, here capacity, diffusion, production, resistance"));
}

TEST(Tree, NamesThePlaceInTheListNotInTheOrderOfEmission) {
  EXPECT_THAT(refusal(tree({state("D", "N", {{"x", 1}}), state("N")})).first, "states[0].skills.x");
}

TEST(Tree, RefusesAValueThatASkillCannotHave) {
  EXPECT_THAT(refusal(tree({state("N", "", {{"diffusion", 1.5}})})),
              Pair("states[0].skills.diffusion", "'diffusion' is 1.5 but must be from 0 to 1"));
  EXPECT_THAT(refusal(tree({state("N", "", {{"capacity", -1}})})),
              Pair("states[0].skills.capacity", "'capacity' is -1 but must be at least 0"));
}

TEST(Tree, BudgetCountsValueTimesCostOverAllSkills) {
  // 3 + 2 x 5, and diffusion free of charge.
  Tree::Parameters parameters =
      tree({state("N", "", {{"production", 3}, {"resistance", 5}, {"diffusion", 0.5}})});
  parameters.budget = 13;
  EXPECT_EQ(refusal(parameters).second, "no refusal");
  parameters.budget = 12.5;
  EXPECT_THAT(refusal(parameters),
              Pair("states[0].skills", "'N' spends 13 points; the budget is 12.5"));
}

TEST(Tree, BudgetHoldsForEveryState) {
  Tree::Parameters parameters = tree({state("N"), state("D", "N", {{"resistance", 10}})});
  parameters.budget = 13;
  EXPECT_THAT(refusal(parameters),
              Pair("states[1].skills", "'D' spends 20 points; the budget is 13"));
}

TEST(Tree, BudgetForgivesTheRoundingOfDecimals) {
  Tree::Parameters parameters = tree({state("N", "", {{"capacity", 0.1}, {"production", 0.2}})});
  parameters.budget = 0.3;  // 0.1 + 0.2 is a hair above
  EXPECT_EQ(refusal(parameters).second, "no refusal");
}

TEST(Tree, ReadsItsParametersFromTheHost) {
  Tree::Parameters parameters;
  Describe d;
  parameters.describe(d);
  ASSERT_EQ(d.parameters().size(), 3u);
  const ParameterInfo& states = d.parameters()[0];
  EXPECT_STREQ(states.name, "states");
  EXPECT_EQ(states.required, 1u);
  const ParameterInfo& element = states.fields[0];
  std::vector<std::string> names;
  for (std::uint64_t i = 0; i < element.field_count; ++i)
    names.emplace_back(element.fields[i].name);
  EXPECT_THAT(names, ElementsAre("name", "parent", "mass", "radius", "stiffness", "adhesion",
                                 "adhesion_range", "motility", "motility_signal",
                                 "quiescence_threshold", "division_threshold",
                                 "specialization_threshold", "apoptosis_threshold", "skills"));
  EXPECT_EQ(element.fields[0].required, 1u);
  EXPECT_STREQ(d.parameters()[1].name, "budget");
  EXPECT_EQ(d.parameters()[1].fallback.kind, ParameterKind::none);
  EXPECT_EQ(d.parameters()[1].maximum, 1e9);
  const ParameterInfo& pairs = d.parameters()[2];
  EXPECT_STREQ(pairs.name, "adhesion_pairs");
  EXPECT_EQ(pairs.required, 0u);
  ASSERT_EQ(pairs.fields[0].field_count, 3u);
  for (std::uint64_t i = 0; i < 3; ++i) EXPECT_EQ(pairs.fields[0].fields[i].required, 1u);
}

}  // namespace
}  // namespace somas::specialization
