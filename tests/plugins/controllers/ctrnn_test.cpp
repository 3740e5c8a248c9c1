#include "plugins/controllers/ctrnn/ctrnn.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include <gmock/gmock.h>

#include "tests/plugins/controllers/support.hpp"

namespace somas::ctrnn {
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

// All weights and biases 0, every tau the same.
Network blank(const Layout& layout, std::uint32_t hidden, double tau) {
  Network network;
  network.hidden = hidden;
  network.inputs = common::sorted_keys(layout.inputs);
  network.outputs = common::sorted_keys(layout.outputs);
  network.genes.resize(network.rows() * network.columns());
  for (std::size_t row = 0; row < network.rows(); ++row) network.neuron(row)[Network::tau] = tau;
  return network;
}

std::size_t input_column(const Network& network, std::string_view name) {
  return Network::first_weight + network.hidden +
         common::find_key(network.inputs, stable_key(name)).value();
}

std::size_t output_row(const Network& network, std::string_view name) {
  return network.hidden + common::find_key(network.outputs, stable_key(name)).value();
}

Ctrnn with_hidden(std::int64_t hidden) {
  Parameters p;
  p.hidden = hidden;
  return Ctrnn(p);
}

double sigma(double x) { return 1 / (1 + std::exp(-x)); }

// ---- steps computed by hand
// ----------------------------------------------------------------------

// One hidden neuron h (bias 0, tau 2, weight from itself 4, from the input 1), one output o (bias
// -1, tau 4, weight from h 8, from the input -2); input 0.5; y_h = 0, y_o = 1 at the start.
//   sigma(y_h + 0) = 0.5
//   y_h = 0 + (-0 + 4 x 0.5 + 1 x 0.5) / 2 = 1.25
//   y_o = 1 + (-1 + 8 x 0.5 - 2 x 0.5) / 4 = 1.5;   out = sigma(1.5 - 1) = 0.62245933
// Second step, sigma(1.25) = 0.77729986:
//   y_h = 1.25 + (-1.25 + 4 x 0.77729986 + 0.5) / 2 = 2.42959972
//   y_o = 1.5 + (-1.5 + 8 x 0.77729986 - 1) / 4 = 2.42959972;   out = sigma(1.42959972)
TEST(CtrnnStep, FollowsTheEquation) {
  const TestLayout layout({"n"}, {"energy"}, {"o"});
  Network network = blank(layout.view(), 1, 1);
  std::ranges::copy(std::vector<double>{0, 2, 4, 1}, network.neuron(0).begin());
  std::ranges::copy(std::vector<double>{-1, 4, 8, -2}, network.neuron(1).begin());
  const Ctrnn ctrnn = with_hidden(1);
  const auto program = ctrnn.express(encoded(network), layout.view());
  ASSERT_EQ(program->memory_per_cell(), 2u);
  Cells cells(*program, layout.view(), 1);
  cells.in[0] = 0.5f;
  cells.memory = {0, 1};
  program->step(cells.batch(0));
  EXPECT_NEAR(cells.memory[0], 1.25, 1e-6);
  EXPECT_NEAR(cells.memory[1], 1.5, 1e-6);
  EXPECT_NEAR(cells.out[0], 0.62245933, 1e-6);
  program->step(cells.batch(0));
  EXPECT_NEAR(cells.memory[0], 2.42959972, 1e-6);
  EXPECT_NEAR(cells.memory[1], 2.42959972, 1e-6);
  EXPECT_NEAR(cells.out[0], sigma(1.42959972), 1e-6);
}

TEST(CtrnnStep, WithoutDriveAPotentialDecaysGeometrically) {
  const TestLayout layout({"n"}, {"energy"}, {"o"});
  const Ctrnn ctrnn = with_hidden(1);
  for (const double tau : {1.0, 1.5, 5.0, 20.0}) {
    const auto program = ctrnn.express(encoded(blank(layout.view(), 1, tau)), layout.view());
    Cells cells(*program, layout.view(), 1);
    cells.in[0] = 1;
    cells.memory = {0.8f, -3.0f};
    for (int t = 1; t <= 40; ++t) {
      program->step(cells.batch(0));
      ASSERT_NEAR(cells.memory[0], 0.8 * std::pow(1 - 1 / tau, t), 1e-6);
      ASSERT_NEAR(cells.memory[1], -3.0 * std::pow(1 - 1 / tau, t), 4e-6);
    }
  }
}

TEST(CtrnnStep, OnlyTheInputsOfTheCellsOwnStateAct) {
  const TestLayout layout({"n", "d"}, {"energy", "pressure"}, {"o", "p"});
  Network network = blank(layout.view(), 0, 1);
  network.neuron(output_row(network, "o"))[input_column(network, "n.energy")] = 1;
  network.neuron(output_row(network, "o"))[input_column(network, "d.energy")] = 2;
  network.neuron(output_row(network, "p"))[input_column(network, "n.pressure")] = 4;
  network.neuron(output_row(network, "p"))[input_column(network, "d.pressure")] = 8;
  const auto program = with_hidden(0).express(encoded(network), layout.view());
  for (std::uint16_t state = 0; state < 2; ++state) {
    Cells cells(*program, layout.view(), 1);
    cells.in = {0.5f, 0.25f};
    program->step(cells.batch(state));
    EXPECT_FLOAT_EQ(cells.memory[0], state == 0 ? 0.5f : 1.0f);
    EXPECT_FLOAT_EQ(cells.memory[1], state == 0 ? 1.0f : 2.0f);
  }
}

// In double and one cell at a time.
TEST(CtrnnStep, AgreesWithANaiveImplementation) {
  const TestLayout layout = rich_layout();
  const Layout view = layout.view();
  const Ctrnn ctrnn{Parameters{}};
  for (std::uint64_t g = 0; g < 60; ++g) {
    const Genes genes = evolved_genes(ctrnn.heritable(), view, g, static_cast<int>(g % 7));
    const Network network = decode(genes);
    const auto program = ctrnn.express(genes, view);
    const auto state = static_cast<std::uint16_t>(g % 3);
    Cells cells(*program, view, 1);
    Rng rng = test_rng(g);
    fill_uniform(cells.in, rng);
    const std::size_t h = network.hidden;
    std::vector<double> y(network.rows());  // rows of the genome
    for (int t = 0; t < 8; ++t) {
      program->step(cells.batch(state));
      std::vector<double> next = y;
      for (std::size_t row = 0; row < network.rows(); ++row) {
        const auto neuron = network.neuron(row);
        double drive = 0;
        for (std::size_t j = 0; j < h; ++j)
          drive += neuron[2 + j] * sigma(y[j] + network.neuron(j)[Network::bias]);
        for (const Port& port : view.inputs)
          if (port.state == state)
            drive += neuron[input_column(network, port.name)] *
                     static_cast<double>(cells.in[port.channel]);
        next[row] += (drive - y[row]) / neuron[Network::tau];
      }
      y = next;
      for (std::size_t j = 0; j < h; ++j) ASSERT_NEAR(cells.memory[j], y[j], 2e-3);
      for (const Port& port : view.outputs) {
        const std::size_t row = output_row(network, port.name);
        ASSERT_NEAR(cells.memory[h + port.channel], y[row], 2e-3);
        ASSERT_NEAR(cells.out[port.channel], sigma(y[row] + network.neuron(row)[Network::bias]),
                    1e-3);
      }
    }
  }
}

TEST(CtrnnStep, SplittingABatchChangesNoBit) {
  const TestLayout layout = rich_layout();
  const Ctrnn ctrnn{Parameters{}};
  for (std::uint64_t g = 0; g < 8; ++g) {
    const auto program =
        ctrnn.express(random_genes(ctrnn.heritable(), layout.view(), g), layout.view());
    Cells whole(*program, layout.view(), 150, 160);
    Rng rng = test_rng(g);
    fill_uniform(whole.in, rng);
    fill_uniform(whole.memory, rng);
    Cells split = whole;
    for (int t = 0; t < 5; ++t) {
      program->step(whole.batch(2));
      for (std::uint32_t first = 0, n = 1; first < 150;
           first += n, n = std::min(n + 3, 150 - first))
        program->step(split.batch(2, first, n));
    }
    ASSERT_EQ(std::memcmp(whole.out.data(), split.out.data(), 4 * whole.out.size()), 0);
    ASSERT_EQ(std::memcmp(whole.memory.data(), split.memory.data(), 4 * whole.memory.size()), 0);
  }
}

// ---- heredity
// ------------------------------------------------------------------------------------

TEST(CtrnnHeredity, KeepsTheLawsOfHeritable) {
  const TestLayout layout = rich_layout();
  const Ctrnn ctrnn{Parameters{}};
  somas::testing::expect_laws_of_heredity(ctrnn.heritable(), layout.view(), 300);
}

TEST(CtrnnHeredity, KeepsTheLawsWithoutHiddenNeuronsAndWithFixedTau) {
  Parameters p;
  p.hidden = 0;
  p.tau_min = p.tau_max = 3;
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Ctrnn ctrnn(p);
  somas::testing::expect_laws_of_heredity(ctrnn.heritable(), layout.view(), 500);
}

TEST(CtrnnMutation, ChangesTheConfiguredShareOfGenesByTheConfiguredAmount) {
  Parameters p;
  p.mutation_rate = 0.2;
  p.mutation_sigma = 0.01;
  const TestLayout layout({"n"}, {"a", "b", "c"}, {"x", "y"});
  const Ctrnn ctrnn(p);
  // In the middle of every range, so that nothing is clamped: width 32, tau's 19.
  Network network = blank(layout.view(), 6, 10.5);
  const Genes genes = encoded(network);
  double changed = 0;
  double squares = 0;
  double total = 0;
  for (std::uint64_t i = 0; i < 500; ++i) {
    Genes copy = genes;
    Rng rng = test_rng(i);
    ctrnn.heritable().mutate(layout.view(), rng, copy);
    const Network after = decode(copy);
    for (std::size_t g = 0; g < after.genes.size(); ++g) {
      const double width = g % after.columns() == Network::tau ? 19 : 32;
      const double step = (after.genes[g] - network.genes[g]) / width;
      total += 1;
      changed += step != 0 ? 1 : 0;
      squares += step * step;
    }
  }
  EXPECT_NEAR(changed / total, 0.2, 5 * std::sqrt(0.16 / total));
  EXPECT_NEAR(std::sqrt(squares / changed), 0.01, 5 * 0.01 / std::sqrt(2 * changed));
}

TEST(CtrnnMutation, ChangesOneGeneAtLeast) {
  Parameters p;
  p.mutation_rate = 0;
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Ctrnn ctrnn(p);
  const Network before = blank(layout.view(), 6, 10);
  std::set<std::size_t> reached;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    Genes copy = encoded(before);
    Rng rng = test_rng(i);
    ctrnn.heritable().mutate(layout.view(), rng, copy);
    const Network after = decode(copy);
    std::size_t changed = 0;
    for (std::size_t g = 0; g < after.genes.size(); ++g)
      if (after.genes[g] != before.genes[g]) {
        ++changed;
        reached.insert(g);
      }
    ASSERT_EQ(changed, 1u);
  }
  EXPECT_EQ(reached.size(), before.genes.size());
}

TEST(CtrnnMutation, StaysWithinTheRanges) {
  Parameters p;
  p.mutation_rate = 1;
  p.mutation_sigma = 1;
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Ctrnn ctrnn(p);
  Genes genes = random_genes(ctrnn.heritable(), layout.view(), 1);
  Rng rng = test_rng(1);
  for (int i = 0; i < 2000; ++i) {
    ctrnn.heritable().mutate(layout.view(), rng, genes);
    ASSERT_NO_THROW(ctrnn.heritable().check(layout.view(), genes));
  }
}

TEST(CtrnnCrossover, InheritsNeuronsWhole) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x", "y"});
  const Ctrnn ctrnn = with_hidden(2);
  const Genes a = random_genes(ctrnn.heritable(), layout.view(), 1);
  const Genes b = random_genes(ctrnn.heritable(), layout.view(), 2);
  const Network first = decode(a);
  const Network second = decode(b);
  std::map<int, int> patterns;
  for (std::uint64_t i = 0; i < 8000; ++i) {
    Rng rng = test_rng(i);
    Genes child;
    ctrnn.heritable().cross(layout.view(), a, b, rng, child);
    const Network c = decode(child);
    int pattern = 0;
    for (std::size_t row = 0; row < 4; ++row) {
      const bool from_first = std::ranges::equal(c.neuron(row), first.neuron(row));
      ASSERT_TRUE(from_first || std::ranges::equal(c.neuron(row), second.neuron(row)));
      pattern = 2 * pattern + (from_first ? 1 : 0);
    }
    ++patterns[pattern];
  }
  ASSERT_EQ(patterns.size(), 16u);
  for (const auto& [pattern, count] : patterns)
    EXPECT_NEAR(count, 500, 5 * std::sqrt(8000 * 15.0 / 256)) << pattern;
}

// a knows states n and s, b only n: a neuron from b has its weights of s from a.
TEST(CtrnnCrossover, TakesWeightsOfInputsThatOneParentHasFromThatOne) {
  const TestLayout small({"n"}, {"a"}, {"x"});
  const TestLayout large({"n", "s"}, {"a"}, {"x", "y"});
  const Ctrnn ctrnn = with_hidden(1);
  const Genes a = random_genes(ctrnn.heritable(), large.view(), 1);
  const Genes b = random_genes(ctrnn.heritable(), small.view(), 2);
  const Network first = decode(a), second = decode(b);
  const auto weight = [](const Network& network, std::size_t row, const Port& port) {
    const std::size_t input = *common::find_key(network.inputs, port.key);
    return network.neuron(row)[Network::first_weight + network.hidden + input];
  };
  const std::size_t y = 1 + *common::find_key(first.outputs, large.view().outputs[1].key);
  const Port &of_n = large.view().inputs[0], &of_s = large.view().inputs[1];
  std::set<bool> hidden_from_a;
  for (std::uint64_t i = 0; i < 100; ++i) {
    Rng rng = test_rng(i);
    Genes child;
    ctrnn.heritable().cross(large.view(), i % 2 ? b : a, i % 2 ? a : b, rng, child);
    const Network c = decode(child);
    EXPECT_TRUE(std::ranges::equal(c.neuron(y), first.neuron(y))) << "b has no such neuron";
    EXPECT_EQ(weight(c, 0, of_s), weight(first, 0, of_s));
    hidden_from_a.insert(weight(c, 0, of_n) == weight(first, 0, of_n));
    EXPECT_TRUE(weight(c, 0, of_n) == weight(first, 0, of_n) ||
                weight(c, 0, of_n) == weight(second, 0, of_n));
  }
  EXPECT_EQ(hidden_from_a.size(), 2u);
}

TEST(CtrnnGenes, WeightsFromANewStateBeginAsThoseOfTheStateAbove) {
  const TestLayout small({"n"}, {"a"}, {"x"});
  const TestLayout large({"n", "s"}, {"a"}, {"x"});
  const Ctrnn ctrnn = with_hidden(1);
  Genes genes = random_genes(ctrnn.heritable(), small.view(), 1);
  Rng rng = test_rng(2);
  ctrnn.heritable().conform(large.view(), rng, genes);
  const Network network = decode(genes);
  for (std::size_t row = 0; row < network.rows(); ++row)
    EXPECT_EQ(network.neuron(row)[Network::first_weight + 1],
              network.neuron(row)[Network::first_weight + 2]);
}

// Both lack nothing but: a has bias 16 where b has -16 (1), and b's tau is 10.5 against 1 (0.5):
// 1.5 over the 3 genes (bias, tau, weight) of the only neuron.
TEST(CtrnnDistance, IsTheMeanOverGenes) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Ctrnn ctrnn = with_hidden(0);
  Network a = blank(layout.view(), 0, 1);
  Network b = blank(layout.view(), 0, 10.5);
  a.neuron(0)[Network::bias] = 16;
  b.neuron(0)[Network::bias] = -16;
  EXPECT_DOUBLE_EQ(ctrnn.heritable().distance(encoded(a), encoded(b)), 0.5);
  // A second input: its weight is a fourth gene, which a lacks.
  const TestLayout wider({"n"}, {"a", "b"}, {"x"});
  Network c = blank(wider.view(), 0, 10.5);
  c.neuron(0)[Network::bias] = -16;
  EXPECT_DOUBLE_EQ(ctrnn.heritable().distance(encoded(a), encoded(c)), 2.5 / 4);
}

TEST(CtrnnConform, KeepsTheGenesOfSurvivingPorts) {
  const TestLayout small({"n", "d"}, {"a", "b"}, {"x", "y"});
  const TestLayout large({"n", "d", "s"}, {"a", "b"}, {"x", "z", "y"});
  const Ctrnn ctrnn{Parameters{}};
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Genes genes = random_genes(ctrnn.heritable(), small.view(), i);
    Genes other = genes;
    Rng rng = test_rng(i);
    ctrnn.heritable().conform(large.view(), rng, other);
    ASSERT_NO_THROW(ctrnn.heritable().check(large.view(), other));
    const Network before = decode(genes);
    const Network after = decode(other);
    for (const char* output : {"x", "y"})
      for (const char* input : {"n.a", "n.b", "d.a", "d.b"})
        ASSERT_EQ(after.neuron(output_row(after, output))[input_column(after, input)],
                  before.neuron(output_row(before, output))[input_column(before, input)]);
    ctrnn.heritable().conform(small.view(), rng, other);
    ASSERT_EQ(other, genes);
  }
}

TEST(CtrnnConform, DoesNotDependOnTheOrderOfPorts) {
  const TestLayout forward({"n", "d"}, {"a", "b"}, {"x", "y", "z"});
  const TestLayout backward({"d", "n"}, {"b", "a"}, {"z", "x", "y"});
  const Ctrnn ctrnn{Parameters{}};
  const Genes genes = random_genes(ctrnn.heritable(), forward.view(), 5);
  EXPECT_EQ(random_genes(ctrnn.heritable(), backward.view(), 5), genes);
  const auto straight = ctrnn.express(genes, forward.view());
  const auto crossed = ctrnn.express(genes, backward.view());
  Cells one(*straight, forward.view(), 1);
  Cells two(*crossed, backward.view(), 1);
  one.in = {0.25f, 0.75f};
  two.in = {0.75f, 0.25f};
  straight->step(one.batch(0));
  crossed->step(two.batch(1));
  EXPECT_NEAR(one.out[0], two.out[1], 1e-6);
  EXPECT_NEAR(one.out[1], two.out[2], 1e-6);
  EXPECT_NEAR(one.out[2], two.out[0], 1e-6);
}

TEST(CtrnnConform, FitsGenomesOfOtherParameters) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  Genes genes = random_genes(with_hidden(2).heritable(), layout.view(), 1);
  const Network before = decode(genes);
  Parameters p;
  p.hidden = 4;
  p.weight_limit = 1;
  const Ctrnn ctrnn(p);
  Rng rng = test_rng(1);
  ctrnn.heritable().conform(layout.view(), rng, genes);
  EXPECT_NO_THROW(ctrnn.heritable().check(layout.view(), genes));
  const Network after = decode(genes);
  EXPECT_EQ(after.neuron(1)[Network::bias], before.neuron(1)[Network::bias]);
  EXPECT_EQ(after.neuron(4)[Network::tau], before.neuron(2)[Network::tau]);
}

// ---- check, parameters, JSON
// ---------------------------------------------------------------------

TEST(CtrnnCheck, RefusesCorruptGenes) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x", "y"});
  const Ctrnn ctrnn{Parameters{}};
  const Genes genes = random_genes(ctrnn.heritable(), layout.view(), 1);
  somas::testing::expect_corruption_refused(ctrnn.heritable(), layout.view(), genes);
}

TEST(CtrnnCheck, SaysWhatIsWrong) {
  const TestLayout layout({"n"}, {"a", "b"}, {"x", "y"});
  const Ctrnn ctrnn = with_hidden(1);
  const auto error_with = [&](auto spoil) {
    Network network = blank(layout.view(), 1, 2);
    spoil(network);
    return error_of([&] { ctrnn.heritable().check(layout.view(), encoded(network)); }).value_or("");
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_with([](Network&) {}), "");
  EXPECT_THAT(error_with([](Network& n) { n.genes[0] = 17; }), HasSubstr("is 17.0"));
  EXPECT_THAT(error_with([&](Network& n) { n.genes[3] = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(error_with([](Network& n) { n.neuron(1)[Network::tau] = 0.5; }),
              HasSubstr("below 1"));
  EXPECT_THAT(error_with([](Network& n) { std::swap(n.outputs[0], n.outputs[1]); }),
              HasSubstr("output keys of the genes do not ascend"));
  EXPECT_THAT(error_of([&] {
                with_hidden(2).heritable().check(layout.view(),
                                                 encoded(blank(layout.view(), 1, 2)));
              }).value_or(""),
              HasSubstr("1 hidden neurons where 2"));
  const TestLayout wider({"n"}, {"a", "b", "c"}, {"x", "y"});
  EXPECT_THAT(error_of([&] {
                static_cast<void>(ctrnn.express(encoded(blank(layout.view(), 1, 2)), wider.view()));
              }).value_or(""),
              HasSubstr("lack the input port \"n.c\""));
}

TEST(CtrnnParameters, ContradictionsNameTheParameter) {
  const auto path_with = [](auto member, auto value) -> std::string {
    Parameters p;
    p.*member = value;
    try {
      const Ctrnn ctrnn(p);
    } catch (const ParameterError& error) {
      return error.path();
    }
    return "";
  };
  EXPECT_EQ(path_with(&Parameters::tau_min, 0.5), "tau_min");
  EXPECT_EQ(path_with(&Parameters::tau_min, 21.0), "tau_min");
  EXPECT_EQ(path_with(&Parameters::hidden, 65), "hidden");
  EXPECT_EQ(path_with(&Parameters::hidden, 64), "");
}

TEST(CtrnnJson, RefusesNeuronsOfAnotherShape) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  const Ctrnn ctrnn = with_hidden(2);
  auto json = nlohmann::json::parse(somas::testing::to_json_text(
      ctrnn.heritable(), random_genes(ctrnn.heritable(), layout.view(), 1)));
  EXPECT_EQ(json["hidden"].size(), 2u);
  EXPECT_EQ(json["outputs"][0]["key"], common::key_text(stable_key("x")));
  json["hidden"][1]["from_inputs"].push_back(0.5);
  Genes genes;
  EXPECT_THAT(error_of([&] {
                ctrnn.heritable().from_json(somas::testing::JsonIn(json), genes);
              }).value_or(""),
              HasSubstr("2 weights from_inputs where the network has 1"));
}

// What one controller evolved must not be taken for the genes of another.
TEST(CtrnnCheck, RefusesGenesOfAnotherController) {
  const TestLayout layout({"n"}, {"a"}, {"x"});
  Genes genes = random_genes(with_hidden(2).heritable(), layout.view(), 1);
  genes[0] = 'G';
  EXPECT_THAT(
      error_of([&] { with_hidden(2).heritable().check(layout.view(), genes); }).value_or(""),
      HasSubstr("not those of a recurrent neural network"));
}

}  // namespace
}  // namespace somas::ctrnn
