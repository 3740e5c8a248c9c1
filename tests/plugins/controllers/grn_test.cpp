#include "plugins/controllers/grn/grn.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include <gmock/gmock.h>

#include "tests/plugins/controllers/support.hpp"

namespace somas::grn {
namespace {

using somas::testing::Cells;
using somas::testing::error_of;
using somas::testing::evolved_genes;
using somas::testing::fill_uniform;
using somas::testing::random_genes;
using somas::testing::rich_layout;
using somas::testing::test_rng;
using somas::testing::TestLayout;
using ::testing::HasSubstr;

Genes encoded(const Network& network) {
  Genes genes;
  encode(network, genes);
  return genes;
}

Protein& protein_of(PortProteins& ports, std::string_view name) {
  return ports.proteins.at(common::find_key(ports.keys, stable_key(name)).value());
}

// A network of the layout with all tags 0, to be filled in by hand.
Network blank(const Layout& layout, double beta, double delta, std::size_t regulators) {
  Network network;
  network.beta = beta;
  network.delta = delta;
  network.inputs = {common::sorted_keys(layout.inputs), {}};
  network.inputs.proteins.resize(layout.inputs.size());
  network.outputs = {common::sorted_keys(layout.outputs), {}};
  network.outputs.proteins.resize(layout.outputs.size());
  network.regulators.resize(regulators);
  return network;
}

Grn with_affinity(const char* affinity) {
  Parameters p;
  p.affinity = affinity;
  return Grn(p);
}

// ---- networks computed by hand ------------------------------------------------------------------

// One input, one output, no regulators; N = 2, beta = 2, delta = 1. Tags: input id 0.5; output
// enhancer 0.4, inhibitor 0.9. One pair, so that u+ = u+max and u- = u-max whatever they are: both
// exponentials are 1 and the weight is 0.
TEST(GrnStep, SinglePairIsItsOwnMaximumAndCancels) {
  const TestLayout layout({"n"}, {"energy"}, {"division"});
  Network network = blank(layout.view(), 2, 1, 0);
  network.inputs.proteins[0].id = 0.5;
  network.outputs.proteins[0] = {0, 0.4, 0.9};
  for (const char* affinity : {"proximity", "distance"}) {
    const Grn grn = with_affinity(affinity);
    const auto program = grn.express(encoded(network), layout.view());
    Cells cells(*program, layout.view(), 1);
    cells.in[0] = 1;
    program->step(cells.batch(0));
    EXPECT_EQ(cells.out[0], 0.0f);
  }
}

// One input (id 0.5), two outputs: a (enhancer 0.5, inhibitor 0), b (enhancer 0.75, inhibitor 0.5).
// N = 3, beta = 2, delta = 0.75, so delta/N = 0.25; input concentration 0.5.
//
// proximity: u+ a 1, b 0.75, max 1; u- a 0.5, b 1, max 1.
//   W_a = 0.25 (e^0 - e^(2(0.5 - 1))) = 0.25 (1 - e^-1);  W_b = 0.25 (e^-0.5 - 1)
// distance: u+ a 0, b 0.25, max 0.25; u- a 0.5, b 0, max 0.5.
//   W_a = 0.25 (e^(2(0 - 0.25)) - 1) = 0.25 (e^-0.5 - 1);  W_b = 0.25 (1 - e^(2(0 - 0.5)))
struct TwoOutputs : ::testing::Test {
  TestLayout layout{{"n"}, {"energy"}, {"a", "b"}};
  Network network = blank(layout.view(), 2, 0.75, 0);
  TwoOutputs() {
    protein_of(network.inputs, "n.energy").id = 0.5;
    protein_of(network.outputs, "a") = {0, 0.5, 0};
    protein_of(network.outputs, "b") = {0, 0.75, 0.5};
  }
};

TEST_F(TwoOutputs, FollowTheEquationByProximity) {
  const Grn grn = with_affinity("proximity");
  const auto program = grn.express(encoded(network), layout.view());
  Cells cells(*program, layout.view(), 1);
  cells.in[0] = 0.5f;
  program->step(cells.batch(0));
  const double e1 = 0.36787944117144233;   // e^-1
  const double e05 = 0.60653065971263342;  // e^-0.5
  EXPECT_NEAR(cells.out[0], 0.125 * (1 - e1), 1e-7);
  EXPECT_NEAR(cells.out[1], 0.125 * (e05 - 1), 1e-7);
  // An inhibited output is reported below 0 and remembered as 0.
  EXPECT_LT(cells.out[1], 0);
  EXPECT_EQ(cells.memory[1], 0.0f);
  // The other accumulates.
  program->step(cells.batch(0));
  EXPECT_NEAR(cells.out[0], 0.25 * (1 - e1), 1e-7);
  EXPECT_EQ(cells.memory[0], cells.out[0]);
  EXPECT_NEAR(cells.out[1], 0.125 * (e05 - 1), 1e-7);
}

TEST_F(TwoOutputs, FollowTheEquationByDistance) {
  const Grn grn = with_affinity("distance");
  const auto program = grn.express(encoded(network), layout.view());
  Cells cells(*program, layout.view(), 1);
  cells.in[0] = 0.5f;
  program->step(cells.batch(0));
  EXPECT_NEAR(cells.out[0], 0.125 * (0.60653065971263342 - 1), 1e-7);
  EXPECT_NEAR(cells.out[1], 0.125 * (1 - 0.36787944117144233), 1e-7);
}

TEST_F(TwoOutputs, SaturateInMemoryButNotInTheReport) {
  const Grn grn = with_affinity("proximity");
  const auto program = grn.express(encoded(network), layout.view());
  Cells cells(*program, layout.view(), 1);
  cells.in[0] = 1;
  cells.memory[0] = 0.95f;
  program->step(cells.batch(0));
  EXPECT_NEAR(cells.out[0], 0.95 + 0.25 * (1 - 0.36787944117144233), 1e-6);  // 1.108
  EXPECT_EQ(cells.memory[0], 1.0f);
}

// A regulator r regulates itself and the output; there are no inputs. N = 2, beta = 1, delta = 0.5,
// so delta/N = 0.25. r: id 1, enhancer 1, inhibitor 0; output: enhancer 0, inhibitor 0.
// proximity: u+ r<-r 1, out<-r 0, max 1; u- r<-r 0, out<-r 0, max 0.
//   W_rr = 0.25 (1 - 1) = 0;  W_or = 0.25 (e^-1 - 1)
// distance: u+ r 0, out 1, max 1; u- r 1, out 1, max 1.
//   W_rr = 0.25 (e^-1 - 1);  W_or = 0.25 (1 - 1) = 0
TEST(GrnStep, RegulatorsRegulateThemselves) {
  const TestLayout layout({"n"}, {}, {"out"});
  Network network = blank(layout.view(), 1, 0.5, 1);
  network.regulators[0] = {1, 1, 0};
  const double w = 0.25 * (0.36787944117144233 - 1);

  const auto near = with_affinity("proximity").express(encoded(network), layout.view());
  Cells cells(*near, layout.view(), 1);
  cells.memory = {0.5f, 0.8f};  // the output, then the regulator
  near->step(cells.batch(0));
  EXPECT_NEAR(cells.out[0], 0.5 + w * 0.8, 1e-7);
  EXPECT_NEAR(cells.memory[1], 0.8, 1e-7);

  const auto far = with_affinity("distance").express(encoded(network), layout.view());
  cells.memory = {0.5f, 0.8f};
  far->step(cells.batch(0));
  EXPECT_NEAR(cells.out[0], 0.5, 1e-7);
  EXPECT_NEAR(cells.memory[1], 0.8 + w * 0.8, 1e-7);
}

// Outputs regulate nothing: their concentrations do not change what happens to anything else.
TEST(GrnStep, OutputsDoNotRegulate) {
  const TestLayout layout = rich_layout();
  const Grn grn{Parameters{}};
  const auto program = grn.express(random_genes(grn.heritable(), layout.view(), 3), layout.view());
  Cells a(*program, layout.view(), 1);
  Rng rng = test_rng(1);
  fill_uniform(a.in, rng);
  fill_uniform(a.memory, rng);
  Cells b = a;
  b.memory[0] = a.memory[0] > 0.5f ? 0.1f : 0.9f;
  program->step(a.batch(0));
  program->step(b.batch(0));
  for (std::size_t i = 1; i < a.memory.size(); ++i) EXPECT_EQ(a.memory[i], b.memory[i]);
}

// Two states, one input each. The inactive input is 0 in the sums, yet counts in N and in umax.
// ids: n 0.5, d 0.0; outputs a (enhancer 0, inhibitor 0.5), b (enhancer 0.5, inhibitor 0).
// N = 4, delta = 1, beta = 2; proximity: every maximum is 1.
//   state n: W_a = 0.25 (e^(2(0.5-1)) - 1), W_b = 0.25 (1 - e^-1)
//   state d: W_a = 0.25 (1 - e^-1),         W_b = 0.25 (e^-1 - 1)
// Were d's input ignored, N would be 3.
TEST(GrnStep, OnlyTheInputsOfTheCellsOwnStateAct) {
  const TestLayout layout({"n", "d"}, {"energy"}, {"a", "b"});
  Network network = blank(layout.view(), 2, 1, 0);
  protein_of(network.inputs, "n.energy").id = 0.5;
  protein_of(network.inputs, "d.energy").id = 0.0;
  protein_of(network.outputs, "a") = {0, 0, 0.5};
  protein_of(network.outputs, "b") = {0, 0.5, 0};
  const auto program = with_affinity("proximity").express(encoded(network), layout.view());
  const double w = 0.25 * (1 - 0.36787944117144233);
  for (std::uint16_t state = 0; state < 2; ++state) {
    Cells cells(*program, layout.view(), 1);
    cells.in[0] = 1;
    program->step(cells.batch(state));
    EXPECT_NEAR(cells.out[0], state == 0 ? -w : w, 1e-7);
    EXPECT_NEAR(cells.out[1], state == 0 ? w : -w, 1e-7);
  }
}

// The maximum of u- comes from an input that is inactive and from no other: with n's alone it would
// be 0.75, with d's (id 0, as a's inhibitor) it is 1.
TEST(GrnStep, MaximaSpanTheInputsOfAllStates) {
  const TestLayout layout({"n", "d"}, {"energy"}, {"a"});
  Network network = blank(layout.view(), 2, 1.5, 0);
  protein_of(network.inputs, "n.energy").id = 0.25;
  protein_of(network.inputs, "d.energy").id = 0.0;
  protein_of(network.outputs, "a") = {0, 0.25, 0};
  const auto program = with_affinity("proximity").express(encoded(network), layout.view());
  Cells cells(*program, layout.view(), 1);
  cells.in[0] = 1;
  program->step(cells.batch(0));
  // delta/N = 0.5; u+ = 1 = max, u- = 0.75 against 1: 0.5 (1 - e^-0.5).
  EXPECT_NEAR(cells.out[0], 0.5 * (1 - 0.60653065971263342), 1e-7);
}

// ---- a naive oracle
// ------------------------------------------------------------------------------

// One cell, straight from docs/model.md section 6, in double with the C library's exp.
struct Oracle {
  const Network& network;
  const Layout& layout;
  bool proximity;

  double u(double tag, double id) const {
    return proximity ? 1 - std::fabs(tag - id) : std::fabs(tag - id);
  }

  // memory: outputs by channel, then regulators; returns the unclamped outputs.
  std::vector<double> step(std::uint16_t state, const std::vector<double>& in,
                           std::vector<double>& memory) const {
    std::vector<Protein> targets(layout.outputs.size());
    for (const Port& port : layout.outputs)
      targets[port.channel] =
          network.outputs.proteins[*common::find_key(network.outputs.keys, port.key)];
    for (const Protein& r : network.regulators) targets.push_back(r);

    std::vector<std::pair<Protein, double>> regulators;
    for (const Port& port : layout.inputs)
      regulators.emplace_back(
          network.inputs.proteins[*common::find_key(network.inputs.keys, port.key)],
          port.state == state ? in[port.channel] : 0.0);
    for (std::size_t r = 0; r < network.regulators.size(); ++r)
      regulators.emplace_back(network.regulators[r], memory[layout.outputs.size() + r]);

    double enhancing_max = -1;
    double inhibiting_max = -1;
    for (const Protein& t : targets)
      for (const auto& [r, c] : regulators) {
        enhancing_max = std::max(enhancing_max, u(t.enhancer, r.id));
        inhibiting_max = std::max(inhibiting_max, u(t.inhibitor, r.id));
      }

    const auto n = static_cast<double>(layout.inputs.size() + targets.size());
    std::vector<double> next;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      double g = 0;
      double h = 0;
      for (const auto& [r, c] : regulators) {
        g += c * std::exp(network.beta * (u(targets[i].enhancer, r.id) - enhancing_max));
        h += c * std::exp(network.beta * (u(targets[i].inhibitor, r.id) - inhibiting_max));
      }
      next.push_back(memory[i] + network.delta * (g / n - h / n));
    }
    for (std::size_t i = 0; i < memory.size(); ++i) memory[i] = std::clamp(next[i], 0.0, 1.0);
    next.resize(layout.outputs.size());
    return next;
  }
};

TEST(GrnStep, AgreesWithANaiveImplementation) {
  const TestLayout rich = rich_layout();
  const TestLayout small({"n"}, {"a"}, {"x", "y", "z"});
  const TestLayout no_inputs({"n"}, {}, {"x"});
  int checked = 0;
  for (const TestLayout* layout : {&rich, &small, &no_inputs})
    for (const bool proximity : {true, false})
      for (std::uint64_t g = 0; g < 60; ++g) {
        const Grn grn = with_affinity(proximity ? "proximity" : "distance");
        const Layout view = layout->view();
        // 0 to 20 mutations: numbers of regulators from none to many, also odd numbers of targets.
        const Genes genes = evolved_genes(grn.heritable(), view, g, static_cast<int>(g % 21));
        const Network network = decode(genes);
        const auto program = grn.express(genes, view);
        const auto state = static_cast<std::uint16_t>(g % view.states.size());
        const Oracle oracle{network, view, proximity};

        Cells cells(*program, view, 3);
        Rng rng = test_rng(900 + g);
        fill_uniform(cells.in, rng);
        std::vector<std::vector<double>> memory(3, std::vector<double>(cells.memory_rows));
        for (int t = 0; t < 12; ++t) {
          program->step(cells.batch(state));
          for (std::uint32_t l = 0; l < 3; ++l) {
            std::vector<double> in;
            for (std::uint32_t c = 0; c < cells.input_rows; ++c)
              in.push_back(cells.in[c * cells.stride + l]);
            const std::vector<double> out = oracle.step(state, in, memory[l]);
            for (std::size_t i = 0; i < out.size(); ++i)
              ASSERT_NEAR(cells.out[i * cells.stride + l], out[i], 1e-5);
            for (std::size_t i = 0; i < memory[l].size(); ++i)
              ASSERT_NEAR(cells.memory[i * cells.stride + l], memory[l][i], 1e-5);
            ++checked;
          }
        }
      }
  EXPECT_EQ(checked, 3 * 2 * 60 * 12 * 3);
}

// ---- lanes
// ---------------------------------------------------------------------------------------

TEST(GrnStep, SplittingABatchOrPermutingItsLanesChangesNoBit) {
  const TestLayout layout = rich_layout();
  const Grn grn{Parameters{}};
  for (std::uint64_t g = 0; g < 8; ++g) {
    const Genes genes = evolved_genes(grn.heritable(), layout.view(), g, static_cast<int>(3 * g));
    const auto program = grn.express(genes, layout.view());
    Cells whole(*program, layout.view(), 150, 160);
    Rng rng = test_rng(g);
    fill_uniform(whole.in, rng);
    fill_uniform(whole.memory, rng);
    Cells split = whole;
    Cells single = whole;
    for (int t = 0; t < 5; ++t) {
      program->step(whole.batch(1));
      for (std::uint32_t first = 0, n = 1; first < 150;
           first += n, n = std::min(n + 3, 150 - first))
        program->step(split.batch(1, first, n));
      for (std::uint32_t l = 150; l-- > 0;) program->step(single.batch(1, l, 1));
    }
    ASSERT_EQ(std::memcmp(whole.out.data(), split.out.data(), 4 * whole.out.size()), 0);
    ASSERT_EQ(std::memcmp(whole.memory.data(), split.memory.data(), 4 * whole.memory.size()), 0);
    ASSERT_EQ(std::memcmp(whole.out.data(), single.out.data(), 4 * whole.out.size()), 0);
    ASSERT_EQ(std::memcmp(whole.memory.data(), single.memory.data(), 4 * whole.memory.size()), 0);
  }
}

TEST(GrnStep, TouchesNothingBeyondItsLanes) {
  const TestLayout layout = rich_layout();
  const Grn grn{Parameters{}};
  const auto program = grn.express(random_genes(grn.heritable(), layout.view(), 1), layout.view());
  Cells cells(*program, layout.view(), 13, 32);
  std::ranges::fill(cells.in, 1.0f);
  std::ranges::fill(cells.memory, 0.25f);
  std::ranges::fill(cells.out, -7.0f);
  program->step(cells.batch(0));
  for (std::uint32_t row = 0; row < cells.memory_rows; ++row)
    for (std::size_t l = 13; l < 32; ++l) EXPECT_EQ(cells.memory[row * 32 + l], 0.25f);
  for (std::uint32_t row = 0; row < cells.output_rows; ++row) {
    for (std::size_t l = 0; l < 13; ++l) EXPECT_NE(cells.out[row * 32 + l], -7.0f);
    for (std::size_t l = 13; l < 32; ++l) EXPECT_EQ(cells.out[row * 32 + l], -7.0f);
  }
}

TEST(GrnStep, TooManyInputsAreRefused) {
  std::vector<std::string> names;
  for (int i = 0; i < 129; ++i) names.push_back("i" + std::to_string(i));
  const TestLayout layout({"n"}, names, {"out"});
  const Grn grn{Parameters{}};
  const Genes genes = random_genes(grn.heritable(), layout.view(), 1);
  const auto error = error_of([&] { static_cast<void>(grn.express(genes, layout.view())); });
  EXPECT_THAT(error.value_or(""), HasSubstr("at most 128 inputs a state, not 129"));
}

// ---- parameters
// ----------------------------------------------------------------------------------

std::string path_of_error(const Parameters& p) {
  try {
    const Grn grn(p);
  } catch (const ParameterError& error) {
    return error.path();
  }
  return "";
}

TEST(GrnParameters, ContradictionsNameTheParameter) {
  const auto with = [](auto member, auto value) {
    Parameters p;
    p.*member = value;
    return path_of_error(p);
  };
  EXPECT_EQ(with(&Parameters::beta_min, 20.5), "beta_min");
  EXPECT_EQ(with(&Parameters::delta_max, 0.01), "delta_min");
  EXPECT_EQ(with(&Parameters::initial_regulators, 41), "initial_regulators");
  EXPECT_EQ(with(&Parameters::max_regulators, 129), "max_regulators");
  EXPECT_EQ(with(&Parameters::affinity, "nearness"), "affinity");
  EXPECT_EQ(with(&Parameters::beta_min, 20.0), "");
  EXPECT_EQ(with(&Parameters::initial_regulators, 40), "");
}

TEST(GrnParameters, DefaultsAreInTheirRangesAndDocumented) {
  Describe d;
  Parameters p;
  p.describe(d);
  EXPECT_EQ(d.parameters().size(), 10u);
  for (const ParameterInfo& info : d.parameters()) {
    EXPECT_STRNE(info.doc, "") << info.name;
    if (info.kind == ParameterKind::choice) continue;
    const double value = info.kind == ParameterKind::number
                             ? info.fallback.number
                             : static_cast<double>(info.fallback.integer);
    EXPECT_GE(value, info.minimum) << info.name;
    EXPECT_LE(value, info.maximum) << info.name;
  }
}

// ---- heredity
// ------------------------------------------------------------------------------------

TEST(GrnHeredity, KeepsTheLawsOfHeritable) {
  const TestLayout layout = rich_layout();
  const Grn grn{Parameters{}};
  somas::testing::expect_laws_of_heredity(grn.heritable(), layout.view(), 1000);
}

TEST(GrnHeredity, KeepsTheLawsAtTheBoundsOfItsParameters) {
  Parameters p;
  p.initial_regulators = p.max_regulators = 2;
  p.beta_min = p.beta_max = 3;
  p.delta_min = p.delta_max = 1;
  p.crossover_threshold = 0;
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Grn grn(p);
  somas::testing::expect_laws_of_heredity(grn.heritable(), layout.view(), 300);
}

TEST(GrnHeredity, RandomGenomesSpreadOverTheirRanges) {
  const TestLayout layout = rich_layout();
  const Grn grn{Parameters{}};
  double beta_sum = 0;
  double delta_sum = 0;
  double tag_sum = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Network network = decode(random_genes(grn.heritable(), layout.view(), i));
    ASSERT_EQ(network.regulators.size(), 3u);
    ASSERT_EQ(network.inputs.proteins.size(), 21u);
    ASSERT_EQ(network.outputs.proteins.size(), 10u);
    ASSERT_TRUE(network.beta >= 0.5 && network.beta <= 20);
    ASSERT_TRUE(network.delta >= 0.05 && network.delta <= 2);
    beta_sum += network.beta;
    delta_sum += network.delta;
    tag_sum += network.regulators[2].inhibitor;
  }
  // Means of uniforms, five standard errors.
  EXPECT_NEAR(beta_sum / 2000, 10.25, 5 * 19.5 / std::sqrt(12 * 2000));
  EXPECT_NEAR(delta_sum / 2000, 1.025, 5 * 1.95 / std::sqrt(12 * 2000));
  EXPECT_NEAR(tag_sum / 2000, 0.5, 5 / std::sqrt(12 * 2000));
}

// What one edit did.
struct Edits {
  int modified = 0;
  int added = 0;
  int deleted = 0;
  std::map<std::size_t, int> tags;  // 3 * protein + tag
};

Edits single_edits(const Genes& genes, const Grn& grn, const Layout& layout, int draws) {
  const Network before = decode(genes);
  const auto tags_of = [](const Network& network) {
    std::vector<double> tags;
    for (const auto* part :
         {&network.inputs.proteins, &network.outputs.proteins, &network.regulators})
      for (const Protein& p : *part) tags.insert(tags.end(), {p.id, p.enhancer, p.inhibitor});
    return tags;
  };
  const std::vector<double> old_tags = tags_of(before);
  Edits edits;
  for (int i = 0; i < draws; ++i) {
    Genes copy = genes;
    Rng rng = test_rng(70'000 + static_cast<std::uint64_t>(i));
    grn.heritable().mutate(layout, rng, copy);
    const Network after = decode(copy);
    if (after.regulators.size() > before.regulators.size()) {
      ++edits.added;
      // The others stay as and where they were.
      Network shorter = after;
      shorter.regulators.pop_back();
      EXPECT_EQ(shorter, before);
      continue;
    }
    if (after.regulators.size() < before.regulators.size()) {
      ++edits.deleted;
      EXPECT_EQ(after.inputs, before.inputs);
      EXPECT_EQ(after.outputs, before.outputs);
      continue;
    }
    ++edits.modified;
    const std::vector<double> new_tags = tags_of(after);
    int changes = 0;
    for (std::size_t t = 0; t < new_tags.size(); ++t)
      if (new_tags[t] != old_tags[t]) {
        ++edits.tags[t];
        ++changes;
      }
    EXPECT_EQ(changes, 1);
  }
  return edits;
}

Grn single_edit_grn(std::int64_t max_regulators) {
  Parameters p;
  p.initial_regulators = 2;
  p.max_regulators = max_regulators;
  p.max_edits = 1;
  p.rate_redraw = 0;
  return Grn(p);
}

// Five standard deviations of a binomial.
double slack(int draws, double p) { return 5 * std::sqrt(draws * p * (1 - p)); }

TEST(GrnMutation, EditsAreEquiprobableAndReachEveryTagOfEveryProtein) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x", "y", "z"});
  const Grn grn = single_edit_grn(40);
  const int draws = 30000;
  const Genes genes = random_genes(grn.heritable(), layout.view(), 9);
  const Edits edits = single_edits(genes, grn, layout.view(), draws);
  EXPECT_NEAR(edits.modified, draws / 3.0, slack(draws, 1.0 / 3));
  EXPECT_NEAR(edits.added, draws / 3.0, slack(draws, 1.0 / 3));
  EXPECT_NEAR(edits.deleted, draws / 3.0, slack(draws, 1.0 / 3));
  ASSERT_EQ(edits.tags.size(), 21u);  // 7 proteins, 3 tags each
  for (const auto& [tag, count] : edits.tags)
    EXPECT_NEAR(count, edits.modified / 21.0, slack(edits.modified, 1.0 / 21)) << tag;
}

TEST(GrnMutation, ImpossibleEditsAreDrawnAgain) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x"});
  const int draws = 20000;
  // At the most regulators nothing is added ...
  const Grn full = single_edit_grn(2);
  const Edits at_most =
      single_edits(random_genes(full.heritable(), layout.view(), 4), full, layout.view(), draws);
  EXPECT_EQ(at_most.added, 0);
  EXPECT_NEAR(at_most.modified, draws / 2.0, slack(draws, 0.5));
  // ... and without any, nothing is deleted.
  const Grn grn = single_edit_grn(40);
  Network network = decode(random_genes(grn.heritable(), layout.view(), 4));
  network.regulators.clear();
  const Edits at_none = single_edits(encoded(network), grn, layout.view(), draws);
  EXPECT_EQ(at_none.deleted, 0);
  EXPECT_NEAR(at_none.modified, draws / 2.0, slack(draws, 0.5));
}

TEST(GrnMutation, ReturnsWhenNoEditIsPossible) {
  Parameters p;
  p.initial_regulators = p.max_regulators = 0;
  const TestLayout layout({"n"}, {}, {});
  const Grn grn(p);
  Genes genes = random_genes(grn.heritable(), layout.view(), 1);
  Rng rng = test_rng(1);
  grn.heritable().mutate(layout.view(), rng, genes);
  EXPECT_NO_THROW(grn.heritable().check(layout.view(), genes));
}

TEST(GrnMutation, DeletesEveryRegulatorEquallyOften) {
  const TestLayout layout({"n"}, {}, {"x"});
  const Grn grn = single_edit_grn(40);
  Network network = blank(layout.view(), 1, 1, 4);
  for (std::size_t i = 0; i < 4; ++i) network.regulators[i].id = 0.1 * static_cast<double>(i);
  const Genes genes = encoded(network);
  std::map<double, int> missing;
  int deleted = 0;
  for (std::uint64_t i = 0; i < 12000; ++i) {
    Genes copy = genes;
    Rng rng = test_rng(i);
    grn.heritable().mutate(layout.view(), rng, copy);
    const Network after = decode(copy);
    if (after.regulators.size() != 3) continue;
    ++deleted;
    for (const Protein& p : network.regulators)
      if (std::ranges::find(after.regulators, p) == after.regulators.end()) ++missing[p.id];
  }
  ASSERT_EQ(missing.size(), 4u);
  for (const auto& [id, count] : missing)
    EXPECT_NEAR(count, deleted / 4.0, slack(deleted, 0.25)) << id;
}

// Without regulators every edit is a modification, seen as one tag of 24 that differs.
TEST(GrnMutation, MakesOneToFourEditsEquallyOften) {
  const TestLayout layout({"n"}, {"a", "b", "c", "d"}, {"w", "x", "y", "z"});
  Parameters p;
  p.initial_regulators = p.max_regulators = 0;  // modifications only
  p.rate_redraw = 0;
  const Grn grn(p);
  const Genes genes = random_genes(grn.heritable(), layout.view(), 2);
  std::map<std::size_t, int> lengths;
  const int draws = 8000;
  for (std::uint64_t i = 0; i < draws; ++i) {
    Genes copy = genes;
    Rng rng = test_rng(i);
    grn.heritable().mutate(layout.view(), rng, copy);
    std::size_t changed = 0;
    for (std::size_t at = 0; at < genes.size(); at += 8)
      changed += std::memcmp(genes.data() + at, copy.data() + at, 8) != 0 ? 1 : 0;
    ++lengths[changed];
  }
  // Two edits in the same of 24 tags show as one: P(1) = 1/4 (1 + 1/24 + ...).
  EXPECT_EQ(lengths[0], 0);
  EXPECT_EQ(lengths.rbegin()->first, 4u);
  EXPECT_NEAR(lengths[1], draws * 0.25 * (1 + 1.0 / 24 + 1.0 / 576), slack(draws, 0.26) + 10);
  EXPECT_NEAR(lengths[4], draws * 0.25 * (23.0 / 24) * (22.0 / 24) * (21.0 / 24),
              slack(draws, 0.19));
}

TEST(GrnMutation, RedrawsBetaAndDeltaIndependentlyWithinTheirBounds) {
  const TestLayout layout = rich_layout();
  const Grn grn{Parameters{}};
  const Genes genes = random_genes(grn.heritable(), layout.view(), 2);
  const Network before = decode(genes);
  int beta = 0;
  int delta = 0;
  int both = 0;
  const int draws = 10000;
  for (std::uint64_t i = 0; i < draws; ++i) {
    Genes copy = genes;
    Rng rng = test_rng(i);
    grn.heritable().mutate(layout.view(), rng, copy);
    const Network after = decode(copy);
    const bool beta_changed = after.beta != before.beta;
    const bool delta_changed = after.delta != before.delta;
    beta += beta_changed ? 1 : 0;
    delta += delta_changed ? 1 : 0;
    both += beta_changed && delta_changed ? 1 : 0;
    ASSERT_TRUE(after.beta >= 0.5 && after.beta <= 20);
    ASSERT_TRUE(after.delta >= 0.05 && after.delta <= 2);
  }
  EXPECT_NEAR(beta, draws * 0.2, slack(draws, 0.2));
  EXPECT_NEAR(delta, draws * 0.2, slack(draws, 0.2));
  EXPECT_NEAR(both, draws * 0.04, slack(draws, 0.04));
}

TEST(GrnMutation, NeverExceedsTheMostRegulators) {
  Parameters p;
  p.max_regulators = 4;
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Grn grn(p);
  Genes genes = random_genes(grn.heritable(), layout.view(), 1);
  Rng rng = test_rng(1);
  std::set<std::size_t> seen;
  for (int i = 0; i < 5000; ++i) {
    grn.heritable().mutate(layout.view(), rng, genes);
    grn.heritable().check(layout.view(), genes);
    seen.insert(decode(genes).regulators.size());
  }
  EXPECT_EQ(seen, (std::set<std::size_t>{0, 1, 2, 3, 4}));
}

// ---- crossover
// -----------------------------------------------------------------------------------

TEST(GrnCrossover, DistanceWeighsTheIdMost) {
  EXPECT_DOUBLE_EQ(protein_distance({0, 0, 0}, {1, 0, 0}), 0.75);
  EXPECT_DOUBLE_EQ(protein_distance({0, 0, 0}, {0, 1, 0}), 0.125);
  EXPECT_DOUBLE_EQ(protein_distance({0, 0, 0}, {0, 0, 1}), 0.125);
  EXPECT_DOUBLE_EQ(protein_distance({0.5, 0.75, 1}, {0.25, 1, 0}), 0.1875 + 0.03125 + 0.125);
}

TEST(GrnCrossover, TakesPortsAndRatesFromEitherParentIndependently) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x"});
  const Grn grn{Parameters{}};
  const Genes a = random_genes(grn.heritable(), layout.view(), 1);
  const Genes b = random_genes(grn.heritable(), layout.view(), 2);
  const Network first = decode(a);
  const Network second = decode(b);
  std::map<int, int> patterns;
  const int draws = 16000;
  for (std::uint64_t i = 0; i < draws; ++i) {
    Rng rng = test_rng(i);
    Genes child;
    grn.heritable().cross(layout.view(), a, b, rng, child);
    const Network c = decode(child);
    int pattern = 0;
    const auto record = [&](auto of) {
      ASSERT_TRUE(of(c) == of(first) || of(c) == of(second));
      pattern = 2 * pattern + (of(c) == of(first) ? 1 : 0);
    };
    record([](const Network& n) { return n.beta; });
    record([](const Network& n) { return n.delta; });
    record([](const Network& n) { return n.inputs.proteins[0]; });
    record([](const Network& n) { return n.inputs.proteins[1]; });
    record([](const Network& n) { return n.outputs.proteins[0]; });
    ++patterns[pattern];
  }
  ASSERT_EQ(patterns.size(), 32u);
  for (const auto& [pattern, count] : patterns)
    EXPECT_NEAR(count, draws / 32.0, slack(draws, 1.0 / 32)) << pattern;
}

// a: 0.50 0.10; b: 0.52 0.58 0.95 (ids; other tags 0). Distances of pairs, times 0.75: 0.50-0.52
// 0.015, 0.50-0.58 0.06; 0.10 and 0.95 are beyond 0.15 of anything. Greedy: 0.50 pairs with 0.52,
// so 0.10 is alone in a; 0.58 and 0.95 are alone in b. Children: {0.50|0.52, 0.10} or
// {0.50|0.52, 0.58, 0.95}, each of the four with 1/4.
TEST(GrnCrossover, PairsTheNearestAndTakesTheRestFromOneParent) {
  const TestLayout layout({"n"}, {}, {"x"});
  const Grn grn{Parameters{}};
  Network a = blank(layout.view(), 1, 1, 2);
  Network b = blank(layout.view(), 1, 1, 3);
  a.regulators = {{0.50, 0, 0}, {0.10, 0, 0}};
  b.regulators = {{0.95, 0, 0}, {0.58, 0, 0}, {0.52, 0, 0}};
  std::map<std::vector<double>, int> children;
  const int draws = 8000;
  for (std::uint64_t i = 0; i < draws; ++i) {
    Rng rng = test_rng(i);
    Genes child;
    grn.heritable().cross(layout.view(), encoded(a), encoded(b), rng, child);
    std::vector<double> ids;
    for (const Protein& p : decode(child).regulators) ids.push_back(p.id);
    ++children[ids];
  }
  ASSERT_EQ(children.size(), 4u);
  for (const std::vector<double>& ids :
       {std::vector{0.50, 0.10}, {0.52, 0.10}, {0.95, 0.58, 0.50}, {0.95, 0.58, 0.52}})
    EXPECT_NEAR(children[ids], draws / 4.0, slack(draws, 0.25)) << ids.size();
}

TEST(GrnCrossover, PairsNothingAtTheThreshold) {
  Parameters p;
  p.crossover_threshold = 0.1875;  // exactly 0.75 x 0.25
  const TestLayout layout({"n"}, {}, {"x"});
  const Grn grn(p);
  Network a = blank(layout.view(), 1, 1, 2);
  Network b = a;
  a.regulators = {{0.5, 0, 0}, {0, 0, 0}};
  b.regulators = {{0.75, 0, 0}};
  for (std::uint64_t i = 0; i < 200; ++i) {
    Rng rng = test_rng(i);
    Genes child;
    grn.heritable().cross(layout.view(), encoded(a), encoded(b), rng, child);
    const Network c = decode(child);
    EXPECT_TRUE(c.regulators == a.regulators || c.regulators == b.regulators);
  }
}

// a has ports of n and s, b of n and t, the child of n and s: s always comes from a, n from either.
TEST(GrnCrossover, TakesPortsThatOneParentHasFromThatOne) {
  const TestLayout with_s({"n", "s"}, {"a"}, {"x", "specialize.s"});
  const TestLayout with_t({"n", "t"}, {"a"}, {"x", "specialize.t"});
  const Grn grn{Parameters{}};
  const Genes a = random_genes(grn.heritable(), with_s.view(), 1);
  const Genes b = random_genes(grn.heritable(), with_t.view(), 2);
  const Network left = decode(a);
  const auto of = [](const PortProteins& ports, const Port& port) {
    return ports.proteins[*common::find_key(ports.keys, port.key)];
  };
  const Layout layout = with_s.view();
  std::set<bool> from_a;
  for (std::uint64_t i = 0; i < 200; ++i) {
    Rng rng = test_rng(i);
    Genes child;
    const bool swap = i % 2 == 1;
    grn.heritable().cross(layout, swap ? b : a, swap ? a : b, rng, child);
    grn.heritable().check(layout, child);
    const Network c = decode(child);
    EXPECT_EQ(of(c.inputs, layout.inputs[1]), of(left.inputs, layout.inputs[1]));
    EXPECT_EQ(of(c.outputs, layout.outputs[1]), of(left.outputs, layout.outputs[1]));
    from_a.insert(of(c.inputs, layout.inputs[0]) == of(left.inputs, layout.inputs[0]));
  }
  EXPECT_EQ(from_a.size(), 2u);
}

TEST(GrnGenes, InputsOfANewStateBeginAsThoseOfTheStateAbove) {
  const TestLayout small({"n"}, {"a", "b"}, {"x"});
  const TestLayout large({"n", "s"}, {"a", "b"}, {"x", "specialize.s"});
  const Grn grn{Parameters{}};
  Genes genes = random_genes(grn.heritable(), small.view(), 1);
  Rng rng = test_rng(2);
  grn.heritable().conform(large.view(), rng, genes);
  const Network network = decode(genes);
  const auto input = [&](std::size_t port) {
    const std::uint64_t key = large.view().inputs[port].key;
    return network.inputs.proteins[*common::find_key(network.inputs.keys, key)];
  };
  EXPECT_EQ(input(2), input(0));
  EXPECT_EQ(input(3), input(1));
  EXPECT_NE(input(0), input(1));
}

TEST(GrnDistance, IsTheMeanOverRatesAndProteins) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Grn grn{Parameters{}};
  Network a = blank(layout.view(), 0.5, 0.05, 1);
  Network b = blank(layout.view(), 20, 0.05, 2);
  b.inputs.proteins[0].id = 0.5;       // 0.375
  b.outputs.proteins[0].enhancer = 1;  // 0.125
  b.regulators[1].id = 1;              // alone: 1
  // rates 1 and 0, input 0.375, output 0.125, regulators 0 and 1: 2.5 over 6.
  EXPECT_DOUBLE_EQ(grn.heritable().distance(encoded(a), encoded(b)), 2.5 / 6);
}

// ---- conform
// -------------------------------------------------------------------------------------

TEST(GrnConform, KeepsTheGenesOfSurvivingPorts) {
  const TestLayout small({"n", "d"}, {"a", "b"}, {"x", "y"});
  const TestLayout large({"n", "d", "s"}, {"a", "b"}, {"x", "z", "y"});
  const Grn grn{Parameters{}};
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Genes genes = evolved_genes(grn.heritable(), small.view(), i, static_cast<int>(i % 9));
    Genes other = genes;
    Rng rng = test_rng(i);
    grn.heritable().conform(large.view(), rng, other);
    ASSERT_NO_THROW(grn.heritable().check(large.view(), other));
    Network before = decode(genes);
    Network after = decode(other);
    for (const char* name : {"n.a", "n.b", "d.a", "d.b"})
      ASSERT_EQ(protein_of(after.inputs, name), protein_of(before.inputs, name));
    for (const char* name : {"x", "y"})
      ASSERT_EQ(protein_of(after.outputs, name), protein_of(before.outputs, name));
    ASSERT_EQ(after.regulators, before.regulators);
    // Back again: the new ports are forgotten, and the genome is what it was.
    grn.heritable().conform(small.view(), rng, other);
    ASSERT_EQ(other, genes);
  }
}

TEST(GrnConform, DoesNotDependOnTheOrderOfPorts) {
  const TestLayout forward({"n", "d"}, {"a", "b"}, {"x", "y", "z"});
  const TestLayout backward({"d", "n"}, {"b", "a"}, {"z", "x", "y"});
  const Grn grn{Parameters{}};
  const Genes genes = random_genes(grn.heritable(), forward.view(), 5);
  EXPECT_EQ(random_genes(grn.heritable(), backward.view(), 5), genes);
  Genes conformed = genes;
  Rng rng = test_rng(1);
  grn.heritable().conform(backward.view(), rng, conformed);
  EXPECT_EQ(conformed, genes);

  // Nor does what the network computes, when the cells' channels are permuted along.
  const auto straight = grn.express(genes, forward.view());
  const auto crossed = grn.express(genes, backward.view());
  Cells one(*straight, forward.view(), 1);
  Cells two(*crossed, backward.view(), 1);
  one.in = {0.25f, 0.75f};
  two.in = {0.75f, 0.25f};
  straight->step(one.batch(0));
  crossed->step(two.batch(1));
  EXPECT_NEAR(one.out[0], two.out[1], 1e-7);
  EXPECT_NEAR(one.out[1], two.out[2], 1e-7);
  EXPECT_NEAR(one.out[2], two.out[0], 1e-7);
}

TEST(GrnConform, FitsGenomesOfOtherParameters) {
  Parameters wide;
  wide.initial_regulators = 30;
  wide.beta_max = 100;
  wide.beta_min = 50;
  const TestLayout layout({"n"}, {"a"}, {"x"});
  Genes genes = random_genes(Grn(wide).heritable(), layout.view(), 1);
  Parameters narrow;
  narrow.max_regulators = 5;
  const Grn grn(narrow);
  EXPECT_TRUE(error_of([&] { grn.heritable().check(layout.view(), genes); }));
  Rng rng = test_rng(1);
  const Network before = decode(genes);
  grn.heritable().conform(layout.view(), rng, genes);
  EXPECT_NO_THROW(grn.heritable().check(layout.view(), genes));
  const Network after = decode(genes);
  EXPECT_EQ(after.beta, 20);
  EXPECT_TRUE(
      std::equal(after.regulators.begin(), after.regulators.end(), before.regulators.begin()));
}

// ---- check and JSON
// ------------------------------------------------------------------------------

TEST(GrnCheck, RefusesCorruptGenes) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x", "y"});
  const Grn grn{Parameters{}};
  const Genes genes = random_genes(grn.heritable(), layout.view(), 1);
  somas::testing::expect_corruption_refused(grn.heritable(), layout.view(), genes);
}

TEST(GrnCheck, SaysWhatIsWrong) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x", "y"});
  const Grn grn{Parameters{}};
  const Network good = decode(random_genes(grn.heritable(), layout.view(), 1));
  const auto error_with = [&](auto spoil) {
    Network network = good;
    spoil(network);
    return error_of([&] { grn.heritable().check(layout.view(), encoded(network)); }).value_or("");
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_with([](Network&) {}), "");
  EXPECT_THAT(error_with([](Network& n) { n.beta = 21; }), HasSubstr("beta is 21"));
  EXPECT_THAT(error_with([](Network& n) { n.delta = 0; }), HasSubstr("delta is 0"));
  EXPECT_THAT(error_with([&](Network& n) { n.beta = nan; }), HasSubstr("beta is not finite"));
  EXPECT_THAT(error_with([](Network& n) { n.regulators[1].enhancer = 1.5; }),
              HasSubstr("a tag of a regulatory protein is outside [0, 1]"));
  EXPECT_THAT(error_with([&](Network& n) { n.inputs.proteins[0].id = nan; }),
              HasSubstr("a tag of an input protein"));
  EXPECT_THAT(error_with([](Network& n) { n.outputs.proteins[1].inhibitor = -0.1; }),
              HasSubstr("a tag of an output protein"));
  EXPECT_THAT(error_with([](Network& n) { std::swap(n.inputs.keys[0], n.inputs.keys[1]); }),
              HasSubstr("input keys of the genes do not ascend"));
  EXPECT_THAT(error_with([](Network& n) { n.regulators.resize(41); }),
              HasSubstr("41 regulators where at most 40"));
  const TestLayout wider({"n"}, {"a", "b", "c"}, {"x", "y"});
  EXPECT_THAT(error_of([&] { grn.heritable().check(wider.view(), encoded(good)); }).value_or(""),
              HasSubstr("lack the input port \"n.c\""));
  const TestLayout narrower({"n"}, {"a", "b"}, {"x"});
  EXPECT_THAT(error_of([&] { grn.heritable().check(narrower.view(), encoded(good)); }).value_or(""),
              HasSubstr("hold an output for key"));
  EXPECT_TRUE(error_of([&] { static_cast<void>(grn.express(encoded(good), wider.view())); }));
}

TEST(GrnJson, NamesProteinsAndTags) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Grn grn{Parameters{}};
  Network network = blank(layout.view(), 0.1, 0.25, 1);
  network.regulators[0] = {0.1, 0.2, 0.3};
  const auto json =
      nlohmann::json::parse(somas::testing::to_json_text(grn.heritable(), encoded(network)));
  EXPECT_EQ(json["beta"], 0.1);
  EXPECT_EQ(json["delta"], 0.25);
  EXPECT_EQ(json["inputs"].size(), 1u);
  EXPECT_EQ(json["outputs"][0]["key"], common::key_text(stable_key("x")));
  EXPECT_EQ(json["regulators"][0]["id"], 0.1);
  EXPECT_EQ(json["regulators"][0]["enhancer"], 0.2);
  EXPECT_EQ(json["regulators"][0]["inhibitor"], 0.3);
}

TEST(GrnJson, RefusesWhatCannotBeGenes) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Grn grn{Parameters{}};
  auto json = nlohmann::json::parse(somas::testing::to_json_text(
      grn.heritable(), random_genes(grn.heritable(), layout.view(), 1)));
  json["regulators"][0]["id"] = 2;
  Genes genes;
  EXPECT_THAT(error_of([&] {
                grn.heritable().from_json(somas::testing::JsonIn(json), genes);
              }).value_or(""),
              HasSubstr("regulatory protein is outside [0, 1]"));
}

TEST(GrnGenes, AreTheDocumentedBytes) {
  Network network;
  network.beta = 1;
  network.delta = 2;
  network.outputs = {{0x0102030405060708}, {{0, 0.5, 1}}};
  const Genes genes = encoded(network);
  const Genes expected{'G', 'R', 'N', '1', 0, 0, 0,    0,      //
                       1,   0,   0,   0,   0, 0, 0,    0,      //
                       0,   0,   0,   0,   0, 0, 0xF0, 0x3F,   // 1.0
                       0,   0,   0,   0,   0, 0, 0,    0x40,   // 2.0
                       8,   7,   6,   5,   4, 3, 2,    1,      // key
                       0,   0,   0,   0,   0, 0, 0,    0,      // 0.0
                       0,   0,   0,   0,   0, 0, 0xE0, 0x3F,   // 0.5
                       0,   0,   0,   0,   0, 0, 0xF0, 0x3F};  // 1.0
  EXPECT_EQ(genes, expected);
  EXPECT_EQ(decode(genes), network);
}

}  // namespace
}  // namespace somas::grn
